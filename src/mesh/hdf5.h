/* hdf5.h: declares the reader of datasets of an HDF5 file that nobody has checked; see hdf5.c. Rank 0 only.

   A FileReader keeps the first fault as one line of text. After a fault none of these functions does
   anything, so a caller may ask for one thing after the other and look for a fault once at the end. */
#pragma once
#include "mesh/mesh.h"
#include <hdf5.h>

typedef struct {
  hid_t file;
  const char *path;
  char *message; /* (MESSAGE_LENGTH) "" as long as no fault is found */
} FileReader;

typedef enum { ITEM_REAL, ITEM_INT, ITEM_NAME } ItemKind; /* float64, int32, bytes of NAME_LENGTH */

/* Keeps the first fault as "path: ...", without control characters; later faults are dropped. */
void ReaderFault(FileReader *r, const char *format, ...) __attribute__((format(printf, 2, 3)));
static inline PetscBool ReaderSound(const FileReader *r)
{
  return r->message[0] ? PETSC_FALSE : PETSC_TRUE;
}
/* Reads an attribute of "/" that is a single value of this class, as type `memory`; false: there is none. */
PetscBool ReaderAttribute(FileReader *r, const char *name, H5T_class_t class, hid_t memory, void *value);
/* Checks type and shape of a dataset, which must be there: (n,columns), or (n,) when columns is 0. */
void ReaderInspect(FileReader *r, const char *path, ItemKind kind, int columns, PetscInt *n);
/* Reads a dataset that has passed ReaderInspect: PetscReal or PetscInt data (n,columns). */
void ReaderNumbers(FileReader *r, const char *path, ItemKind kind, void *data);
/* Reads n names that have passed ReaderInspect: each is a letter, then letters, digits, _ or -. */
PetscErrorCode ReaderNames(FileReader *r, const char *path, PetscInt n, char (*names)[NAME_LENGTH]);
/* Lists the names in a group that may be missing, in alphabetical order. kind: word for messages. The caller
   frees names. */
void ReaderMembers(FileReader *r, const char *path, const char *kind, PetscInt *n,
                   char (**names)[NAME_LENGTH]);
