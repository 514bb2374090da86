/* fuzz_scene.c: the bytes are the YAML scene, up to the first zero; behind it words of the command line, a
   zero after each. It is read, completed and resolved against the block mesh that the tests use. The echo of
   a scene that is taken must be taken too, and be its own echo. With QUOIN_FUZZ_SETUP (fuzz_scene_setup) a
   model is set up from it. */
#include "fuzz.h"

enum { MOST_WORDS = 32 };

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
  (void)argc, (void)argv;
  FuzzStart("scene.yaml");
  return 0;
}

#ifdef QUOIN_FUZZ_SETUP
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  FuzzFile(NULL, 0, data, size);
  FuzzSetUp(FuzzPath, FUZZ_MODEL);
  return 0;
}
#else

static const BlockMesh *mesh(void)
{
  static BlockMesh read;
  if (!read.n_blocks && MeshRead(PETSC_COMM_SELF, FUZZ_MODEL, &read)) abort();
  return &read;
}

/* From the first key on: before it stands the name of the file. */
static const char *keys_of(const char *echo)
{
  const char *keys = strstr(echo, "\nmodel: ");
  if (!keys) abort();
  return keys;
}

/* Comments say where a value comes from: the default, or now the echo. Lists have blanks or not. */
static const char *next_of(const char *text)
{
  if (!strncmp(text, "  # ", 4)) text += strcspn(text, "\n");
  return text + strspn(text, " ");
}

static void check_echo(const Scene *scene)
{
  char *words[] = {"quoin", NULL};
  Scene again;
  FuzzFile(NULL, 0, scene->echo, strlen(scene->echo));
  if (SceneRead(PETSC_COMM_SELF, FuzzPath, 1, words, &SceneCompletions, &again)) abort();
  const char *a = keys_of(scene->echo), *b = keys_of(again.echo);
  for (; *(a = next_of(a)) == *(b = next_of(b)); a++, b++)
    if (!*a) break;
  if (*a || *b) {
    fprintf(stderr, "%.200s\n-- the echo of it:\n%.200s\n", a, b);
    abort();
  }
  if (SceneDestroy(&again)) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  char *words[MOST_WORDS + 1] = {"quoin"}, *copy = malloc(size + 1);
  int n = 1;
  if (!copy) abort();
  memcpy(copy, data, size);
  copy[size] = 0;
  const size_t length = strlen(copy);
  for (size_t at = length + 1; at < size && n < MOST_WORDS; at += strlen(copy + at) + 1)
    words[n++] = copy + at;
  Scene scene;
  FuzzFile(NULL, 0, copy, length);
  PetscErrorCode code = SceneRead(PETSC_COMM_SELF, FuzzPath, n, words, &SceneCompletions, &scene);
  if (!code) check_echo(&scene);
  if (!code) code = SceneResolve(PETSC_COMM_SELF, &scene, mesh());
  FuzzCheck(code);
  if (SceneDestroy(&scene)) abort();
  free(copy);
  return 0;
}
#endif
