/* output.h: declares the writers of results: results.h5, results.xdmf, summary.json, history.csv, lines on
   the terminal. */
#pragma once
#include "output/history_file.h"
#include "result/result.h"

/* ---- output_selection.c */
typedef struct {
  PetscBool partly;         /* some rows are left out; false: mesh is *all, and the lists are NULL */
  MeshFields mesh;          /* rows that are written, in the order of model.h5; file: NULL when partly */
  PetscInt *block, *vertex; /* (mesh.n_blocks,), (mesh.n_vertices,) selected numbers in model.h5 */
  PetscInt *block_row, *vertex_row; /* (all blocks,), (all vertices,) row among the written ones, -1: none */
} OutputSelection;
/* Creates the selection. `all` must live as long as `written`. */
PetscErrorCode OutputSelectionCreate(const Scene *scene, const MeshFields *all, OutputSelection *written);
PetscErrorCode OutputSelectionDestroy(OutputSelection *written);
/* Selects the rows of a stage; a face or vertex of a contact that is not selected gets the number -1. */
PetscErrorCode SelectedStage(const OutputSelection *written, const StageFields *all, StageFields *some);
PetscErrorCode SelectedStageDestroy(const OutputSelection *written, StageFields *some);
/* Returns a checksum of the selection of blocks; 0: everything is written. */
uint64_t OutputSelectionChecksum(const OutputSelection *written);

/* ---- results_file.c */
/* The grids of a stage (frame 0), or of one of its frames, in the text of results.xdmf. */
typedef struct {
  PetscInt64 stage, frame, length; /* row of Scene.stages; from 1; [byte] */
} StageGrids;
typedef struct {
  const char *folder;
  const Scene *scene;
  const Model *model;      /* names only */
  OutputSelection written; /* while a file is being written */
  uint64_t choice;         /* OutputSelectionChecksum */
  uint64_t run;            /* the run that writes: CheckpointRun, after a restart CheckpointGoesOn */
  uint64_t origin;         /* the run of the checkpoint, whose files it takes over; else run */
  char *xdmf;              /* grids of the stages written so far: text of results.xdmf */
  PetscInt n_grids;
  StageGrids *grids;  /* (n_grids,) the stages and frames in xdmf, in the order of its text */
  char **stages;      /* texts of Output; NULL: the stage was skipped */
  PetscInt n_frames;  /* frames of the present stage, each in a file of its own until the stage ends */
  PetscBool has_part; /* results.h5.part has all stages so far, results.h5 has fewer */
  int64_t part;       /* results.h5.part, open while stages are added (hid_t); 0: closed */
  int failed;         /* errno of the first write into it that failed */
} ResultsFile;
/* Writes the mesh into results.h5.part. */
PetscErrorCode ResultsFileCreate(ResultsFile *file, char message[MESSAGE_LENGTH]);
/* Writes a frame into <stage>_<frame>.h5, where it stays until the stage ends; not while stages wait for
   ResultsFileFinish. */
PetscErrorCode ResultsFileFrame(ResultsFile *file, PetscInt stage, PetscInt frame, const StageResult *result,
                                const StageFields *fields, char message[MESSAGE_LENGTH]);
/* Adds the end of a stage and its frames to results.h5.part. ResultsFileFinish reports a failure. */
PetscErrorCode ResultsFileStage(ResultsFile *file, PetscInt stage, const StageResult *result,
                                uint64_t checksum, const StageFields *fields);
/* Replaces results.h5 by the finished file if stages have been added, then writes results.xdmf. stage: the
   last one in the file. */
void ResultsFileFinish(ResultsFile *file, PetscInt stage, char message[MESSAGE_LENGTH]);
/* Continues results.h5 after a restart if it has any of the first n stages, else starts a new file; warns of
   stages and frames that are lost and forgets their grids. */
PetscErrorCode ResultsFileResume(ResultsFile *file, PetscInt n, char message[MESSAGE_LENGTH]);
PetscErrorCode ResultsFileDestroy(ResultsFile *file);

/* ---- results_there.c */
/* Checks results.h5 before a restart continues after n stages. Refuses results.h5 of another run, and by
   `auto` also a loss of stages or frames. Frames of another run do not count. */
PetscErrorCode ResultsFileCheck(const ResultsFile *file, PetscInt n, char message[MESSAGE_LENGTH]);

/* ---- xdmf.c */
/* Returns the number of entries of the mixed topology: the cell type before the vertices of each block. */
PetscInt XdmfTopologySize(const MeshFields *mesh);
/* Appends the grids of a stage, or of a frame of it, to results->xdmf; 0 or -1. name: its group in
   results.h5. */
int XdmfAddStage(ResultsFile *results, PetscInt stage, PetscInt frame, const char *name,
                 const StageFields *fields);
/* Returns whether the grids of a stage (frame 0) or frame have been written; takes them out. */
PetscBool XdmfHas(const ResultsFile *results, PetscInt stage, PetscInt frame);
void XdmfDrop(ResultsFile *results, PetscInt stage, PetscInt frame);
/* Writes results.xdmf from all grids so far, in one replacement. */
void XdmfWrite(const ResultsFile *results, char message[MESSAGE_LENGTH]);

/* ---- ground_motions.c */
/* Rank 0. Writes motion_<name>.csv for each motion that the scene scales or corrects. */
void MotionsWrite(const Scene *scene, const char *folder, char message[MESSAGE_LENGTH]);

/* ---- history_rows.c */
/* Rank 0. Writes the header of the history; the next two functions write the headers of the other two.
   HistoryRow writes the rows of the last sample, once. */
void HistoryHeader(FILE *f, const Scene *scene, const Model *model, const Result *found);
void JointHistoryHeader(FILE *f);
void TermHistoryHeader(FILE *f);
void HistoryRow(const Problem *p, PetscReal u_max);
void JointHistoryRows(const Problem *p);
void TermHistoryRows(const Problem *p);

/* ---- summary_motion.c */
/* Rank 0. Writes the member "peaks" of a stage's object in summary.json; the next functions write "bodies",
   "rocking_hinge", "modes", "hinges". */
void SummaryPeaks(Json *json, const Problem *p);
void SummaryBodies(Json *json, const Model *model, const BodyMotion *bodies);
void SummaryRocking(Json *json, const RockingHinge *hinge);
void SummaryVibration(Json *json, const Vibration *v);
void SummaryHinges(Json *json, const Hinges *hinges);

/* ---- summary_blocks.c */
/* Rank 0. Writes "stress" and "stress_by_group"; the next functions write "temperature", "safety", "laws". */
void SummaryStress(Json *json, const Model *model, const MeshFields *mesh, const StageFields *fields);
void SummaryTemperature(Json *json, const MeshFields *mesh, const StageFields *fields);
void SummarySafety(Json *json, const Scene *scene, const MeshFields *mesh, const StageFields *fields);
void SummaryLaws(Json *json, const Scene *scene, const MeshFields *mesh, const StageFields *fields);

/* ---- summary_joints.c */
/* Writes "joints" of a stage or trial; factors only at rest. */
void SummaryJoints(Json *json, const Problem *p, const StageFields *fields);

/* ---- summary_trials.c */
/* Writes the bracket and the trials of a stage, of a transient stage its steps; SummaryMechanism writes the
   mechanism. */
void SummaryTrials(Json *json, const Problem *p);
void SummaryMechanism(Json *json, const Scene *scene, const Trials *trials);

/* ---- terminal.c */
/* Rank 0. Returns whether it is time for a line of progress: every ten seconds, on a terminal twice a
   second. StageShow prints this line; StageShowEnd takes it off a terminal. */
PetscBool StageShows(const Problem *p);
void StageShow(const Problem *p, const char *what);
void StageShowEnd(const Problem *p);
/* Rank 0. Prints, when it is time, how far a stage in time is, its speed, and the time that is left. part:
   [-] fraction of its duration. */
void StageShowTime(const Problem *p, PetscReal part);
/* Prints how a stage ended. */
PetscErrorCode StageReport(const Problem *p);

/* ---- output.c */
typedef struct _p_Output {
  char folder[PETSC_MAX_PATH_LEN];
  PetscInt n_stages;   /* stages that are over */
  PetscInt n_settled;  /* rank 0: finished stages that the files with their final names hold */
  PetscBool settled;   /* the files hold all finished stages: a checkpoint is due */
  double settle_wall;  /* rank 0: [s] that these files took to write last */
  PetscInt n_contacts; /* contacts at the end of the last stage */
  PetscInt n_dofs;     /* degrees of freedom at that end */
  char **stages;       /* rank 0: (n_stages,) their objects in summary.json; NULL: it was not
                                         run, because the stage from which it starts has failed */
  PetscInt *by_factor; /* (n_stages of the scene,) 1: a factor has influenced the state at the end
                                       of the stage, which agrees on any ranks to the tolerance only */
  ResultsFile results; /* rank 0 */
  HistoryFile files[HISTORY_FILES]; /* rank 0; name NULL: this run has none */
  uint64_t program_checksum;        /* rank 0: FileChecksum of the program that runs; 0: it cannot be read */
  int lock;                         /* rank 0: lock of the folder, -1: none */
  PetscInt n_trials;                /* rank 0 */
  char **trials; /* rank 0: (n_trials,) objects of the trials of the stage that runs, in summary.json */
  Result *found; /* of the run */
  struct _p_Checkpoint *checkpoint;
  void *memory; /* output.c: memory for the checkpoint */
} Output;
/* Makes the folder of the scene and keeps other runs out of it until OutputClose. A folder that cannot be
   written, or that another run writes into, is refused. `output` must be zero before. */
PetscErrorCode OutputLock(MPI_Comm comm, const Scene *scene, Output *output);
/* Starts results.h5.part and the histories; after a restart, goes on with the files that are there. Call
   after OutputLock, when set-up has succeeded. Results of an older run stay until the first stage is
   complete. `output` must not move in memory. */
PetscErrorCode OutputOpen(const Scene *scene, const Model *model, struct _p_Checkpoint *checkpoint,
                          Result *found, Output *output);
/* Writes a row of history.csv and the rows of joint_history.csv that a check has left, or these alone. */
PetscErrorCode OutputHistory(const Problem *p);
PetscErrorCode OutputJointHistory(const Problem *p);
/* Writes a frame of a dynamic stage, from 1. The contacts must belong to the present displacements. */
PetscErrorCode OutputFrame(const Problem *p, PetscInt frame);
/* Writes the end of a stage, whatever its verdict: results.h5, results.xdmf, summary.json; history.csv
   takes its name. Many short stages wait for a later stage or a checkpoint: then the files are not
   `settled`. */
PetscErrorCode OutputStage(const Problem *p);
/* Collective. Adds the trial of this value, which has just run, to the stage, and prints it. moved: largest
   displacement [m] since the stage began. */
PetscErrorCode OutputTrial(const Problem *p, PetscReal value, PetscReal moved);
/* Rank 0. Replaces the gids of blocks in a table from LoadsTable by their numbers in model.h5. */
void LoadsNumberFaces(const MeshFields *mesh, TermTable *loads);
/* Forgets the trials of the stage. */
PetscErrorCode OutputDropTrials(Output *output);
/* Skips the next stage, which is not run. */
void OutputPass(Output *output);
/* Collective. Writes the files, where they do not hold all stages yet. */
PetscErrorCode OutputSettle(const Scene *scene, const Model *model, Output *output);
/* Closes the files. message: receives what could not be written at the last moment; "" when nothing failed.
   */
PetscErrorCode OutputClose(Output *output, char message[MESSAGE_LENGTH]);

/* ---- result_query.c */
/* One rank. Finds numbers of the stage that is over by their paths in its object in summary.json, such as
   joints.base.sliding_factor_peak; NaN: there is none. */
PetscErrorCode ResultQuery(const Problem *p, PetscInt n, char *const *paths, PetscReal *values);
/* Returns whether a path asks for more than a number of a joint. */
PetscBool ResultQueryBeyondJoints(PetscInt n, char *const *paths);

/* ---- summary.c */
/* Returns 1 when a factor has influenced the state: this stage or an earlier one ran, or may have run,
   preconditioned. */
PetscInt SummaryByFactor(const Problem *p);
/* Writes the object of a stage with mesh, probes and trials of p->output. checksum: of the whole state, and
   without what is inside condensed bodies. */
PetscErrorCode SummaryStage(Json *json, const Problem *p, const StageFields *fields,
                            const uint64_t checksum[2]);
PetscErrorCode SummaryWrite(const Scene *scene, const Model *model, const struct _p_Output *output,
                            char message[MESSAGE_LENGTH]);
