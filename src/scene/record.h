/* record.h: declares the reader of files of numbers in time, and of numbers at places. */
#pragma once
#include "scene/scene.h"

/* The allowed content of a file. */
typedef struct {
  int least, most;   /* numbers in a row, with the time; most: at most RECORD_WIDEST */
  const char *names; /* of the columns, for messages */
  PetscBool places;  /* rows are places, in any order; else the first number of each is its time */
} RecordShape;
enum { RECORD_WIDEST = 3 };

/* Reads a file on this rank: rows of a table, or of PEER if its name ends with .AT2 or .VT2. quantity: set if
   the file names its quantity. message: receives the fault, with its line. */
PetscErrorCode RecordRead(const char *path, const RecordShape *shape, Record *record,
                          MotionQuantity *quantity, char message[MESSAGE_LENGTH]);
PetscErrorCode RecordDestroy(Record *record);
