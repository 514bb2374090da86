/* results_there.h: declares which stages and frames results.h5 and the files of frames have, for
   results_file.c. */
#pragma once
#include "output/output.h"
#include <hdf5.h>

/* Writes the name of the group of a stage, or of one of its frames, from 1. */
void ResultsGroupName(const ResultsFile *results, PetscInt stage, PetscInt frame,
                      char name[NAME_LENGTH + 16]);
PetscBool ResultsOfThisRun(hid_t file, const ResultsFile *results);
/* Finds which of the first n stages in results->grids are not in the file (negative: none is); lost:
   (n,). Returns how many. */
PetscInt ResultsStagesLost(const ResultsFile *results, hid_t file, PetscInt n, PetscBool *lost);
/* Opens the file that has a frame, and finds its group within; negative: no file has it. A frame has its own
   file; after a restart from before the end of the stage it may be in results.h5 already. message: a file is
   there and cannot be read. */
hid_t ResultsOpenFrame(const ResultsFile *results, const char *name, char within[2 * NAME_LENGTH],
                       char message[MESSAGE_LENGTH]);
/* Finds which frames of a stage that still runs are lost, as ResultsStagesLost; lost: (n_frames,). */
PetscInt ResultsFramesLost(const ResultsFile *results, PetscInt stage, PetscBool *lost,
                           char message[MESSAGE_LENGTH]);
