/* results_there.h: what results.h5 and the files of frames hold: results_there.c, for results_file.c. */
#pragma once
#include "output/output.h"
#include <hdf5.h>

/* The name of the group of a stage; of a frame of it, from 1. */
void ResultsGroupName(const ResultsFile *results, PetscInt stage, PetscInt frame,
                      char name[NAME_LENGTH + 16]);
PetscBool ResultsOfThisRun(hid_t file, const ResultsFile *results);
/* Finds which of the first n stages that results->xdmf has are not in the file (negative: none is); lost:
   (n,). Returns how many. */
PetscInt ResultsStagesLost(const ResultsFile *results, hid_t file, PetscInt n, PetscBool *lost);
/* The file that has a frame, and its group within; negative: none. Its own file; after a restart from before
   the end of the stage it may be in results.h5 already. message: a file is there and cannot be read. */
hid_t ResultsOpenFrame(const ResultsFile *results, const char *name, char within[2 * NAME_LENGTH],
                       char message[MESSAGE_LENGTH]);
/* The same of the frames of a stage that is on its way; lost: (n_frames,). */
PetscInt ResultsFramesLost(const ResultsFile *results, PetscInt stage, PetscBool *lost,
                           char message[MESSAGE_LENGTH]);
