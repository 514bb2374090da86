/* key_paths.c: decides which words may be names in a scene, and paths of keys. */
#include "scene/scene.h"
#include "scene/entries.h"
#include <ctype.h>
#include <string.h>

PetscBool NameIsValid(const char *name)
{
  if (!isalpha((unsigned char)name[0]) || strlen(name) >= NAME_LENGTH) return PETSC_FALSE;
  for (const char *c = name; *c; c++)
    if (!isalnum((unsigned char)*c) && !strchr("_+-", *c)) return PETSC_FALSE;
  return PETSC_TRUE;
}

PetscBool PathIsValid(const char *path)
{
  char name[LABEL_LENGTH];
  for (const char *dot; path; path = dot ? dot + 1 : NULL) {
    dot = strchr(path, '.');
    const size_t length = dot ? (size_t)(dot - path) : strlen(path);
    if (length >= sizeof name) return PETSC_FALSE;
    memcpy(name, path, length), name[length] = '\0';
    if (!NameIsValid(name)) return PETSC_FALSE;
  }
  return PETSC_TRUE;
}
