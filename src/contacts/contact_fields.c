/* contact_fields.c: allocates, copies, lists and frees the arrays of Contacts, by the one list of arrays in
   contacts.h. */
#include "contacts/contacts.h"

static const size_t Numbers[] = {[PER_CONTACT] = 1, [PER_FACE] = 2, [PER_ROW] = CONTACT_ROWS, [PER_END] = 2};

static size_t bytes_of(const Contacts *c, ContactShape shape, size_t size)
{
  return Numbers[shape] * (size_t)c->n_padded * size;
}

/* Returns the index of number k of contact i in an array of this shape. */
static PetscInt place_of(ContactShape shape, PetscInt i, int k)
{
  if (shape == PER_FACE) return 2 * i + k;
  if (shape == PER_ROW) return CONTACT_ROW(i, k);
  return shape == PER_END ? SUB(i, k) : i;
}

/* Rounds the bytes of an array up to whole cache lines. All arrays of ROOM_FULL share one memory: if each had
   its own, all would begin at the same place of a page, and stores to one would delay loads from the next. */
static size_t whole_lines(size_t bytes)
{
  enum { LINE = 64 }; // bytes of a cache line
  return (bytes + LINE - 1) / LINE * LINE;
}

PetscErrorCode ContactsAllocate(Contacts *c)
{
  size_t full = 1, at = 0;
  PetscBool missing = PETSC_FALSE;
  PetscFunctionBeginUser;
#define SIZE(type, name, shape, kind, room)                                                                  \
  if ((room) == ROOM_FULL) full += whole_lines(bytes_of(c, shape, sizeof(type)));
  CONTACT_FIELDS(SIZE)
#undef SIZE
  PetscCall(PetscCalloc1(full, &c->memory));
  // calloc gives the arrays of ROOM_ZEROS zeros without writing them; PetscCalloc would write them
#define PLACE(type, name, shape, kind, room)                                                                 \
  if ((room) == ROOM_FULL)                                                                                   \
    c->name = (void *)(c->memory + at), at += whole_lines(bytes_of(c, shape, sizeof(type)));                 \
  else                                                                                                       \
    c->name = calloc(bytes_of(c, shape, sizeof(type)) + 1, 1), missing |= !c->name;
  CONTACT_FIELDS(PLACE)
#undef PLACE
  PetscCheck(!missing, PETSC_COMM_SELF, PETSC_ERR_MEM, "no memory for %" PetscInt_FMT " contacts",
             c->n_padded);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactsDestroy(Contacts *c)
{
  PetscFunctionBeginUser;
  PetscCall(PetscFree(c->memory));
#define FREE(type, name, shape, kind, room)                                                                  \
  if ((room) == ROOM_ZEROS) free(c->name);                                                                   \
  c->name = NULL;
  CONTACT_FIELDS(FREE)
#undef FREE
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactsCopy(const Contacts *c, Contacts *copy)
{
  PetscFunctionBeginUser;
  *copy = *c;
  PetscCall(ContactsAllocate(copy));
  // zeros of closure are not copied, so that their pages still take no memory
#define COPY(type, name, shape, kind, room)                                                                  \
  if ((kind)&FIELD_CRUSHES) {                                                                                \
    for (PetscInt i = 0; i < 2 * c->n_padded; i++)                                                           \
      if (c->name[i] != 0) copy->name[i] = c->name[i];                                                       \
  } else {                                                                                                   \
    PetscCall(PetscMemcpy(copy->name, c->name, bytes_of(c, shape, sizeof(type))));                           \
  }
  CONTACT_FIELDS(COPY)
#undef COPY
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ContactsCopyOne(const Contacts *c, PetscInt from, Contacts *copy, PetscInt at)
{
#define COPY(type, name, shape, kind, room)                                                                  \
  for (int k = 0; k < (int)Numbers[shape] && (kind) != FIELD_DERIVED; k++) {                                 \
    const type value = c->name[place_of(shape, from, k)];                                                    \
    if (!((kind)&FIELD_CRUSHES) || value != 0) copy->name[place_of(shape, at, k)] = value;                   \
  }
  CONTACT_FIELDS(COPY)
#undef COPY
}

int ContactsEndArrays(const Contacts *c, int kinds, PetscReal *array[END_ARRAYS])
{
  int n = 0;
#define TAKE(type, name, shape, kind, room)                                                                  \
  if ((shape) == PER_END && sizeof(type) == sizeof(PetscReal) && (kind)&kinds)                               \
    array[n++] = (PetscReal *)(void *)c->name;
  CONTACT_FIELDS(TAKE)
#undef TAKE
  return n;
}
