/* term_sections.c: describes the sections of a scene that belong to force terms. */
#include "scene/scene.h"
#include "scene/reader.h"
#include <string.h>

const TermSection TermSections[TERM_SECTION_ROWS] = {
#define ROW_OF_TERM(SECTION, word, type) {word, SECTION_##SECTION, sizeof(type)},
    TERM_SECTIONS(ROW_OF_TERM){NULL, SECTIONS, 0}};

const void *SceneEntries(const Scene *scene, const char *section, PetscInt *n)
{
  *n = 0;
  for (int t = 0; scene->terms && TermSections[t].word; t++) {
    if (strcmp(TermSections[t].word, section)) continue;
    *n = scene->terms[t].n;
    return scene->terms[t].entries;
  }
  return NULL;
}
