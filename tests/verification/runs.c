/* runs.c - runs the program many times and loads its shared libraries once. PETSc brings ninety of them; to
   look up their symbols takes two thirds of the time of a start. Each run is a copy (fork) of this process in
   which neither MPI nor PETSc has been started.
   A request is a line on the standard input. Tabs part its fields: the folder to run in, the files for what
   the run prints and for its errors, then the words of the command line. The answer on the standard output is
   a line with the exit code, or with the number of the signal that ended the run and a minus sign. */
#define main quoin_main
// NOLINTNEXTLINE(bugprone-suspicious-include): the program, by another name
#include "../../src/main.c"
#undef main
#include <fcntl.h>
#include <stdio.h>
#include <sys/wait.h>

enum { WORDS = 200, SECONDS = 500 };

/* Opens a file as descriptor `as`; ends the process where that fails. */
static void redirect(const char *file, int flags, int as)
{
  const int descriptor = open(file, flags, 0666);
  if (descriptor < 0 || dup2(descriptor, as) < 0) _exit(126);
  close(descriptor);
}

/* Parts a line at its tabs into at most `limit` words; returns how many there are. */
static int part(char *line, char **words, int limit)
{
  int n = 0;
  line[strcspn(line, "\n")] = '\0';
  for (char *rest = line; rest && n < limit; n++) words[n] = strsep(&rest, "\t");
  return n;
}

/* Runs the program in this copy of the process and ends it. */
static void run_here(int n, char **words)
{
  if (n < 4 || chdir(words[0])) _exit(126);
  redirect("/dev/null", O_RDONLY, STDIN_FILENO);
  redirect(words[1], O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
  redirect(words[2], O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO);
  alarm(SECONDS);
  exit(quoin_main(n - 3, words + 3));
}

int main(void)
{
  char *line = NULL, *words[WORDS + 1];
  size_t size = 0;
  while (getline(&line, &size, stdin) > 0) {
    const int n = part(line, words, WORDS);
    int status = 0;
    words[n] = NULL;
    const pid_t run = fork();
    if (!run) run_here(n, words);
    if (run < 0 || waitpid(run, &status, 0) < 0) return 1;
    printf("%d\n", WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status));
    fflush(stdout);
  }
  free(line);
  return 0;
}
