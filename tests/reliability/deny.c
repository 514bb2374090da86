/* deny.c: a library to load before the others (LD_PRELOAD) that denies what QUOIN_DENY names, as a system
   does that lacks it: space (in /dev/shm), window (of memory that ranks share), lock (of files), yaml
   (memory for its parser). A number is a signal instead, which comes when the mesh is opened, in the
   middle of set-up. */
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
  if (denied("window")) return NO_MEMORY;
  return NEXT("MPI_Win_allocate_shared", Window *)(size, unit, info, comm, base, window);
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

long H5Fopen(const char *name, unsigned how, long access)
{
  static int sent;
  const int number = getenv("QUOIN_DENY") ? atoi(getenv("QUOIN_DENY")) : 0;
  if (number && !sent++) raise(number);
  return NEXT("H5Fopen", long (*)(const char *, unsigned, long))(name, how, access);
}
