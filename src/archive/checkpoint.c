/* checkpoint.c: writes checkpoints, and restarts a run from them; see archive.h.

   Rank 0 gathers everything and writes it with serial HDF5, as it does with results. So the file is the same
   on any number of ranks, and it can be checked, verified and renamed as a whole (docs/reliability.md has the
   cost). */
#include "archive/archive.h"
#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <unistd.h>

/* ---- signals */

static volatile sig_atomic_t stop_signal = 0, write_signal = 0;
static char stop_line[PETSC_MAX_PATH_LEN + 128]; /* the line that rank 0 prints at once, "" elsewhere */

static void on_signal(int number)
{
  if (number == SIGUSR1) {
    write_signal = 1;
    return;
  }
  if (!stop_signal && stop_line[0]) {
    const ssize_t written = write(STDERR_FILENO, stop_line, strlen(stop_line));
    (void)written;
  }
  stop_signal = number;
}

/* Signals that the run obeys. mpirun sends SIGUSR1 and SIGUSR2 on to all ranks, and leaves them about a
   second after SIGTERM and SIGINT. SIGXCPU comes at the limit of processor time, then each second. A write
   beyond the largest file (ulimit -f) must fail like any other write. */
static const int Caught[] = {SIGUSR1, SIGUSR2, SIGTERM, SIGINT, SIGXCPU, SIGHUP};

void SignalsCatch(void)
{
  struct sigaction action = {.sa_handler = on_signal}, now;
  sigemptyset(&action.sa_mask);
  for (size_t i = 0; i < sizeof(Caught) / sizeof(*Caught); i++)
    if (Caught[i] != SIGHUP || sigaction(SIGHUP, NULL, &now) || now.sa_handler != SIG_IGN) // nohup
      sigaction(Caught[i], &action, NULL);
  signal(SIGXFSZ, SIG_IGN);
}

void SignalsRelease(void)
{
  struct sigaction now;
  for (size_t i = 0; i < sizeof(Caught) / sizeof(*Caught); i++)
    if (!sigaction(Caught[i], NULL, &now) && now.sa_handler == on_signal) signal(Caught[i], SIG_DFL);
}

static void prepare_line(const Checkpoint *c)
{
  if (!c->rank)
    snprintf(stop_line, sizeof(stop_line), "quoin: a signal stops the run; last good checkpoint: %s\n",
             c->last[0] ? c->last : "none");
}

/* ---- files: <output>/checkpoints/checkpoint_<number>.h5 */

static void path_of(const char *folder, PetscInt number, char path[PETSC_MAX_PATH_LEN])
{
  snprintf(path, PETSC_MAX_PATH_LEN, "%.4000s/checkpoint_%06d.h5", folder, (int)number);
}

/* Returns the number in the name of a checkpoint, -1: none. Nine digits are enough for any run. */
enum { LAST_NUMBER = 999999999 };
static PetscInt number_of(const char *name)
{
  int number, end = 0;
  if (sscanf(name, "checkpoint_%9d.h5%n", &number, &end) != 1 || !end || name[end]) return -1;
  return number;
}

/* Finds the largest number below `below` in a folder, -1: none. Returns 0, or errno if the folder cannot
   be read. */
static int newest(const char *folder, PetscInt below, PetscInt *most)
{
  *most = -1;
  DIR *dir = opendir(folder);
  if (!dir) return errno == ENOENT || errno == ENOTDIR ? 0 : errno;
  errno = 0;
  for (struct dirent *entry; (entry = readdir(dir));) {
    const PetscInt number = number_of(entry->d_name);
    if (number < below) *most = PetscMax(*most, number);
  }
  const int error = errno;
  closedir(dir);
  return error;
}

/* Removes all but the newest `keep` files. */
static void rotate(const char *folder, PetscInt number, PetscInt keep)
{
  char path[PETSC_MAX_PATH_LEN];
  for (PetscInt n = number; !newest(folder, n, &n) && n >= 0;) {
    if (--keep > 0) continue;
    path_of(folder, n, path);
    if (unlink(path)) return;
  }
}

/* ---- life */

PetscErrorCode CheckpointCreate(MPI_Comm comm, const Scene *scene, uint64_t mesh, Checkpoint *c)
{
  PetscFunctionBeginUser;
  PetscCall(PetscMemzero(c, sizeof(*c)));
  c->comm = comm, c->scene = scene, c->mesh = mesh;
  PetscCallMPI(MPI_Comm_rank(comm, &c->rank));
  PetscCall(PetscSNPrintf(c->folder, sizeof(c->folder), "%s/checkpoints", scene->output));
  c->number = -1;
  c->start_wall = c->last_wall = c->poll_wall = MPI_Wtime();
  prepare_line(c);
  SignalsCatch();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointDestroy(Checkpoint *c)
{
  PetscFunctionBeginUser;
  PetscCall(ArchiveDestroy(&c->resume));
  c->n_parts = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointRefuse(const Checkpoint *c, PetscErrorCode code, const char *message)
{
  char text[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  if (message[0])
    PetscCall(PetscSNPrintf(text, MESSAGE_LENGTH, "%.600s; last good checkpoint: %.300s", message,
                            c->last[0] ? c->last : "none"));
  PetscCall(Refuse(c->comm, code, text));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- parts */

/* Reads or writes one checkpoint part; its name precedes its entries. */
static PetscErrorCode archive_part(Archive *a, const CheckpointPart *part)
{
  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(a->part, part->name, sizeof(a->part)));
  PetscCall(part->function(a, part->context));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointAttach(Checkpoint *c, const char *name, ArchiveFunction function, void *context,
                                PetscBool *resumed)
{
  CheckpointPart *part = c->parts + c->n_parts;
  char message[MESSAGE_LENGTH] = "";
  PetscFunctionBeginUser;
  PetscCheck(c->n_parts < MOST_PARTS, c->comm, PETSC_ERR_PLIB, "too many parts");
  c->n_parts++;
  PetscCall(PetscStrncpy(part->name, name, sizeof(part->name)));
  part->function = function, part->context = context;
  *resumed = PETSC_FALSE;
  if (!c->resuming) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveHasPart(&c->resume, name, resumed));
  if (!*resumed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(archive_part(&c->resume, part));
  if (c->resume.message[0])
    PetscCall(
        PetscSNPrintf(message, MESSAGE_LENGTH, "restart: '%.500s': %.400s", c->last, c->resume.message));
  PetscCall(Refuse(c->comm, ERROR_CHECKPOINT, message));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointDetach(Checkpoint *c)
{
  PetscFunctionBeginUser;
  c->n_parts--;
  // the stage is over: later parts start without a checkpoint
  c->resuming = PETSC_FALSE;
  PetscCall(ArchiveDestroy(&c->resume));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- writing */

/* Rank 0. Finds the number of the next file, larger than all that exist. */
static void next_number(Checkpoint *c, char message[MESSAGE_LENGTH])
{
  const int error = c->number < 0 ? newest(c->folder, PETSC_MAX_INT, &c->number) : 0;
  if (error) snprintf(message, MESSAGE_LENGTH, "cannot read '%.700s': %s", c->folder, strerror(error));
  if (c->number++ == LAST_NUMBER)
    snprintf(message, MESSAGE_LENGTH, "no number is left in '%.700s' behind %d", c->folder, LAST_NUMBER);
}

PetscErrorCode CheckpointWrite(Checkpoint *c, PetscInt64 cycle)
{
  Archive archive;
  char path[PETSC_MAX_PATH_LEN], message[MESSAGE_LENGTH] = "";
  PetscInt64 mesh = (PetscInt64)c->mesh;
  const double start = MPI_Wtime();
  PetscFunctionBeginUser;
  PetscCall(ArchiveCreate(c->comm, &archive));
  PetscCall(ArchiveCounts(&archive, "mesh", 1, &mesh));
  for (PetscInt i = 0; i < c->n_parts; i++) PetscCall(archive_part(&archive, c->parts + i));
  if (!c->rank) {
    PetscCall(PetscStrncpy(message, archive.message, sizeof(message)));
    if (!message[0]) next_number(c, message);
    path_of(c->folder, c->number, path);
    if (!message[0]) PetscCall(ArchiveWriteFile(&archive, c->folder, path, message));
    if (!message[0]) {
      PetscCall(PetscStrncpy(c->last, path, sizeof(c->last)));
      rotate(c->folder, c->number, c->scene->checkpoint_keep);
    }
  }
  PetscCall(ArchiveDestroy(&archive));
  PetscCall(CheckpointRefuse(c, ERROR_OUTPUT, message));
  prepare_line(c);
  c->last_cycle = cycle;
  c->last_wall = MPI_Wtime();
  c->write_wall = c->last_wall - start;
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode interrupt(const Checkpoint *c, const char *why, StageResult *result)
{
  char last[PETSC_MAX_PATH_LEN];
  PetscFunctionBeginUser;
  PetscCall(PetscStrncpy(last, c->last, sizeof(last)));
  PetscCallMPI(MPI_Bcast(last, sizeof(last), MPI_CHAR, 0, c->comm));
  result->verdict = VERDICT_INTERRUPTED;
  PetscCall(PetscSNPrintf(result->evidence, sizeof(result->evidence),
                          "%s at ratio %.3g; go on with -restart %s", why, (double)result->ratio, last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

enum { STOP, WRITE, TIME, LIMIT, REQUESTS };

/* Collective. Finds what signals and the clock of rank 0 request. */
static PetscErrorCode requests(Checkpoint *c, int request[REQUESTS])
{
  const double now = MPI_Wtime(), minutes = 60. * c->scene->checkpoint_minutes,
               limit = 60. * c->scene->wall_limit;
  // time for two more checks and a checkpoint
  const double ahead = now - c->start_wall + 2. * (now - c->poll_wall) + c->write_wall;
  PetscFunctionBeginUser;
  c->poll_wall = now;
  if (limit > 0. && ahead >= limit) c->limit_near = PETSC_TRUE;
  request[STOP] = stop_signal, request[WRITE] = write_signal;
  request[TIME] = !c->rank && minutes > 0. && now - c->last_wall >= minutes;
  request[LIMIT] = !c->rank && c->limit_near;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, request, REQUESTS, MPI_INT, MPI_MAX, c->comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointPoll(Checkpoint *c, PetscInt64 cycle, StageResult *result)
{
  char why[64];
  int request[REQUESTS];
  PetscFunctionBeginUser;
  if (result->verdict != VERDICT_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(requests(c, request));
  const PetscInt every = c->scene->checkpoint_every;
  const PetscBool stop = (PetscBool)(request[STOP] || request[LIMIT]),
                  due = (PetscBool)(every && cycle - c->last_cycle >= every);
  write_signal = 0;
  if (stop || due || request[WRITE] || request[TIME]) PetscCall(CheckpointWrite(c, cycle));
  if (!stop) PetscFunctionReturn(PETSC_SUCCESS);
  if (request[STOP])
    snprintf(why, sizeof(why), "signal %d", request[STOP]);
  else
    snprintf(why, sizeof(why), "wall time is near its limit, %g min", c->scene->wall_limit);
  PetscCall(interrupt(c, why, result));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointNow(Checkpoint *c, PetscInt64 cycle)
{
  PetscFunctionBeginUser;
  const PetscBool on = (PetscBool)(c->scene->checkpoint_minutes > 0. || c->scene->checkpoint_every);
  if (on && c->folder[0]) PetscCall(CheckpointWrite(c, cycle));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointStop(Checkpoint *c, PetscBool *stop)
{
  int request[REQUESTS];
  PetscFunctionBeginUser;
  PetscCall(requests(c, request));
  *stop = (PetscBool)(request[STOP] || request[LIMIT]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* ---- restart */

/* Decides whether a line is an option that changes no result. */
static PetscBool is_idle(const char *line)
{
  static const char *const idle[] = {"title ",    "output ",     "restart ", "advise ",
                                     "samples ",  "checkpoint.", "model ",   "partition ",
                                     "exchange ", "isa ",        "what_if.", NULL};
  for (const char *const *i = idle; *i; i++)
    if (!strncmp(line, *i, strlen(*i))) return PETSC_TRUE;
  return PETSC_FALSE;
}

/* Hashes the options that change results. */
static uint64_t hash_options(const Checkpoint *c, uint64_t h)
{
  for (const char *line = c->scene->options, *end; line && *line; line = end + (*end == '\n')) {
    end = line + strcspn(line, "\n");
    if (!is_idle(line)) h = HashBytes(h, line, (size_t)(end - line));
  }
  return h;
}

uint64_t CheckpointRun(const Checkpoint *c)
{
  return hash_options(c, c->mesh);
}

uint64_t CheckpointGoesOn(const Checkpoint *c, uint64_t run)
{
  return c->branch ? HashBytes(c->branch, &run, sizeof(run)) : run;
}

/* Decides whether a text was written by EntriesText: lines of a key, a blank and a value. */
static PetscBool are_options(const char *text)
{
  while (*text) {
    const size_t key = strcspn(text, " \n"), length = strcspn(text, "\n");
    if (!key || key == length || !text[length]) return PETSC_FALSE;
    text += length + 1;
  }
  return PETSC_TRUE;
}

/* Returns the value in `text` of the key with which `line` begins, or NULL. */
static const char *value_of(const char *text, const char *line)
{
  const size_t n = strcspn(line, " ") + 1;
  for (const char *at = text; at && *at; at = strchr(at, '\n'), at += at != NULL)
    if (!strncmp(at, line, n)) return at + n;
  return NULL;
}

static PetscBool values_equal(const char *a, const char *b)
{
  char *end[2];
  const size_t n = strcspn(a, "\n");
  if (n == strcspn(b, "\n") && !strncmp(a, b, n)) return PETSC_TRUE;
  const double x = strtod(a, &end[0]), y = strtod(b, &end[1]);
  return (PetscBool)(end[0] != a && end[1] != b && *end[0] == '\n' && *end[1] == '\n' && x == y);
}

/* Prints the change of an option, with its key as the command line has it. */
static void print_change(const char *line, const char *old, const char *new)
{
  char key[6 * NAME_LENGTH];
  snprintf(key, sizeof(key), "%.*s", (int)strcspn(line, " "), line);
  for (char *c = key; *c; c++) *c = *c == '.' ? '_' : *c;
  printf("restart: changed since the checkpoint: %s: %.*s -> %.*s\n", key, old ? (int)strcspn(old, "\n") : 9,
         old ? old : "not given", new ? (int)strcspn(new, "\n") : 9, new ? new : "not given");
}

/* Rank 0. Reports which options differ, key by key. Returns whether any does. */
static PetscBool compare_options(const char *old, const char *new)
{
  PetscBool differ = PETSC_FALSE;
  for (const char *line = new; *line; line = strchr(line, '\n') + 1) {
    const char *before = value_of(old, line), *now = line + strcspn(line, " ") + 1;
    if (is_idle(line) || (before && values_equal(before, now))) continue;
    print_change(line, before, now);
    differ = PETSC_TRUE;
  }
  for (const char *line = old; *line; line = strchr(line, '\n') + 1) {
    if (is_idle(line) || value_of(new, line)) continue;
    print_change(line, line + strcspn(line, " ") + 1, NULL);
    differ = PETSC_TRUE;
  }
  return differ;
}

/* Rank 0. Reads one file into c->resume. message receives why it cannot. */
static PetscErrorCode read_file(Checkpoint *c, const char *path, char message[MESSAGE_LENGTH])
{
  PetscFunctionBeginUser;
  message[0] = 0;
  PetscCall(ArchiveDestroy(&c->resume));
  PetscCall(ArchiveReadFile(&c->resume, path, message));
  if (!message[0]) PetscCall(PetscStrncpy(c->last, path, sizeof(c->last)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0. Reads the newest good file of a folder. found receives whether it has a checkpoint. */
static PetscErrorCode read_newest(Checkpoint *c, const char *folder, PetscBool *found,
                                  char message[MESSAGE_LENGTH])
{
  char path[PETSC_MAX_PATH_LEN], reason[MESSAGE_LENGTH];
  PetscFunctionBeginUser;
  int error;
  *found = PETSC_FALSE;
  for (PetscInt n = PETSC_MAX_INT; !(error = newest(folder, n, &n)) && n >= 0;) {
    *found = PETSC_TRUE;
    path_of(folder, n, path);
    PetscCall(read_file(c, path, reason));
    if (!reason[0]) PetscFunctionReturn(PETSC_SUCCESS);
    Warn("restart: '%s' is passed over: %s", path, reason);
  }
  if (error) {
    *found = PETSC_TRUE; // an unreadable folder may have one
    snprintf(message, MESSAGE_LENGTH, "restart: cannot read '%.700s': %s", folder, strerror(error));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  snprintf(message, MESSAGE_LENGTH, "restart: no good checkpoint in '%.800s'", folder);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/* Rank 0. Finds the file of scene->restart: a file, a folder of checkpoints, an output folder, or auto. */
static PetscErrorCode find_file(Checkpoint *c, PetscBool *found, char message[MESSAGE_LENGTH])
{
  const char *name = c->scene->restart;
  const PetscBool automatic = (PetscBool)!strcmp(name, "auto");
  char folder[PETSC_MAX_PATH_LEN], reason[MESSAGE_LENGTH];
  PetscBool is_folder;
  PetscInt number;
  PetscFunctionBeginUser;
  PetscCall(PetscTestDirectory(name, 'r', &is_folder));
  *found = PETSC_TRUE;
  if (!automatic && !is_folder) {
    PetscCall(read_file(c, name, reason));
    if (reason[0])
      PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "restart: '%.500s': %.400s", name, reason));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscStrncpy(folder, automatic ? c->folder : name, sizeof(folder)));
  if (!automatic && !newest(folder, PETSC_MAX_INT, &number) && number < 0)
    PetscCall(PetscSNPrintf(folder, sizeof(folder), "%.4000s/checkpoints", name));
  PetscCall(read_newest(c, folder, found, message));
  if (automatic && !*found) message[0] = 0; // the run starts from the beginning
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode check_mesh(const Checkpoint *c, char message[MESSAGE_LENGTH])
{
  const ArchiveEntry *mesh = ArchiveFind(&c->resume, "mesh");
  PetscFunctionBeginUser;
  if (!mesh || mesh->kind != ARCHIVE_COUNT || mesh->rows * mesh->columns != 1 ||
      *(PetscInt64 *)mesh->data != (PetscInt64)c->mesh)
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH,
                            "restart: '%.500s' belongs to another block mesh than '%.400s' (or other groups "
                            "are rigid)",
                            c->last, c->scene->model));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointRestart(Checkpoint *c)
{
  char message[MESSAGE_LENGTH] = "", *old = NULL;
  PetscBool found = PETSC_FALSE;
  PetscFunctionBeginUser;
  if (!c->scene->restart[0]) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(ArchiveCreate(c->comm, &c->resume));
  c->resume.reading = PETSC_TRUE;
  if (!c->rank) {
    PetscCall(find_file(c, &found, message));
    if (found && !message[0]) PetscCall(check_mesh(c, message));
  }
  PetscCall(Refuse(c->comm, ERROR_CHECKPOINT, message));
  PetscCallMPI(MPI_Bcast(&found, 1, MPI_PETSC_BOOL, 0, c->comm));
  c->resuming = found;
  if (!found) PetscFunctionReturn(PETSC_SUCCESS);
  prepare_line(c);
  PetscCall(PetscStrncpy(c->resume.part, "run", sizeof(c->resume.part)));
  PetscCall(ArchiveText(&c->resume, "options", &old));
  if (!c->rank && !are_options(old ? old : ""))
    PetscCall(PetscSNPrintf(message, MESSAGE_LENGTH, "restart: '%.900s': its options are damaged", c->last));
  if (message[0]) free(old), old = NULL;
  PetscCall(Refuse(c->comm, ERROR_CHECKPOINT, message));
  if (!c->rank && compare_options(old ? old : "", c->scene->options))
    c->branch = hash_options(c, c->resume.checksum);
  free(old);
  PetscFunctionReturn(PETSC_SUCCESS);
}
