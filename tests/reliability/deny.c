/* deny.c: a library to load before the others (LD_PRELOAD) that denies what QUOIN_DENY names, as a system
   does that lacks it: space (in /dev/shm), window (of memory that ranks share), lock (of files), yaml
   (memory for its parser). A number is a signal instead, which comes when the mesh is opened, in the
   middle of set-up.

   window_<n> denies the n-th window after it has been made, on the rank QUOIN_DENY_RANK of Open MPI (by
   default on all).

   factor_<n> denies the n-th allocation of LARGE bytes or more while a factor of the stiffness is made, on
   that rank. factor_0 denies none, and prints their number.

   kill_<n>_<signal> sends the signal when the n-th checkpoint has got its name; -n: is about to get it. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

#define NEXT(name, type) ((type)dlsym(RTLD_NEXT, name))

static int denied(const char *what)
{
  const char *named = getenv("QUOIN_DENY");
  return named && !strcmp(named, what);
}

static int first_of(const char *word)
{
  const char *named = getenv("QUOIN_DENY");
  return named && !strncmp(named, word, strlen(word)) ? atoi(named + strlen(word)) : -1;
}

static int of_this_rank(void)
{
  const char *rank = getenv("OMPI_COMM_WORLD_RANK"), *wanted = getenv("QUOIN_DENY_RANK");
  return !wanted || !strcmp(rank ? rank : "0", wanted);
}

int statvfs(const char *path, struct statvfs *disk)
{
  const int code = NEXT("statvfs", int (*)(const char *, struct statvfs *))(path, disk);
  if (denied("space") && !strcmp(path, "/dev/shm")) disk->f_bavail = 0;
  return code;
}

typedef int Window(long size, int unit, void *info, void *comm, void *base, void *window);

int MPI_Win_allocate_shared(long size, int unit, void *info, void *comm, void *base, void *window)
{
  enum { NO_MEMORY = 34 };
  static int windows;
  if (denied("window")) return NO_MEMORY;
  const int code = NEXT("MPI_Win_allocate_shared", Window *)(size, unit, info, comm, base, window);
  return ++windows == first_of("window_") && of_this_rank() ? NO_MEMORY : code;
}

/* Of the output folder only: HDF5 locks files, too. */
int flock(int file, int how)
{
  char link[32], path[4096] = "";
  snprintf(link, sizeof(link), "/proc/self/fd/%d", file);
  if (!denied("lock") || readlink(link, path, sizeof(path) - 1) < 0 || !strstr(path, "/quoin.lock"))
    return NEXT("flock", int (*)(int, int))(file, how);
  errno = ENOLCK;
  return -1;
}

int yaml_parser_parse(int *parser, void *event)
{
  enum { YAML_MEMORY_ERROR = 1 };
  if (!denied("yaml")) return NEXT("yaml_parser_parse", int (*)(int *, void *))(parser, event);
  *parser = YAML_MEMORY_ERROR; // the first thing in it is the kind of error
  return 0;
}

int rename(const char *from, const char *to)
{
  static int named;
  int n = 0, number = 0;
  const char *wanted = getenv("QUOIN_DENY");
  if (wanted) sscanf(wanted, "kill_%d_%d", &n, &number);
  if (number && strstr(to, "/checkpoint_")) named++;
  const int here = number && named == abs(n);
  if (here && n < 0) raise(number);
  const int code = NEXT("rename", int (*)(const char *, const char *))(from, to);
  if (here && n > 0) raise(number);
  return code;
}

/* ---- memory within a factor: from the list of entries of the stiffness to PETSc's matrix around the factor,
   or within KSPSetUp */

enum { LARGE = 4096 };
static int inside, allocations;

static int no_memory(size_t size)
{
  if (!inside || size < LARGE) return 0;
  return of_this_rank() && ++allocations == first_of("factor_");
}

extern void *__libc_malloc(size_t size), *__libc_calloc(size_t n, size_t size),
    *__libc_realloc(void *p, size_t size), *__libc_memalign(size_t to, size_t size);

void *malloc(size_t size)
{
  return no_memory(size) ? NULL : __libc_malloc(size);
}

void *calloc(size_t n, size_t size)
{
  return no_memory(n * size) ? NULL : __libc_calloc(n, size);
}

void *realloc(void *p, size_t size)
{
  return no_memory(size) ? NULL : __libc_realloc(p, size);
}

int posix_memalign(void **p, size_t to, size_t size)
{
  *p = no_memory(size) ? NULL : __libc_memalign(to, size);
  return *p ? 0 : ENOMEM;
}

void *memalign(size_t to, size_t size)
{
  return no_memory(size) ? NULL : __libc_memalign(to, size);
}

int PetscSegBufferCreate(size_t unit, size_t n, void *buffer)
{
  enum { ENTRY = 16 }; // or more: of a row, a column and a value
  if (unit >= ENTRY && first_of("factor_") >= 0) inside = 1;
  return NEXT("PetscSegBufferCreate", int (*)(size_t, size_t, void *))(unit, n, buffer);
}

static void leave(void)
{
  inside = 0;
  if (!first_of("factor_")) fprintf(stderr, "deny: %d\n", allocations);
}

typedef int Shell(void *comm, int m, int n, int rows, int columns, void *context, void *matrix);

int MatCreateShell(void *comm, int m, int n, int rows, int columns, void *context, void *matrix)
{
  if (inside) leave();
  return NEXT("MatCreateShell", Shell *)(comm, m, n, rows, columns, context, matrix);
}

int KSPSetUp(void *solver)
{
  inside = first_of("factor_") >= 0;
  const int code = NEXT("KSPSetUp", int (*)(void *))(solver);
  if (inside) leave();
  return code;
}

long H5Fopen(const char *name, unsigned how, long access)
{
  static int sent;
  const int number = getenv("QUOIN_DENY") ? atoi(getenv("QUOIN_DENY")) : 0;
  if (number && !sent++) raise(number);
  return NEXT("H5Fopen", long (*)(const char *, unsigned, long))(name, how, access);
}
