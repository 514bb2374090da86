/* fail_call.c: runs a program and lets ONE of its calls to the system fail, on files of one folder. By
   ptrace, so that no call escapes, whoever makes it (stdio, HDF5, MPI), and no special rights are asked for.
   x86-64.

   fail_call <folder> <calls> <failure> <n> <log> <command> ...

   calls: all, or one of open, read, write, sync, rename, close, truncate. failure: EIO, ENOSPC, EDQUOT; SHORT
   writes half of what a write should. n: which of these calls, from 1; 0: none. log receives the one that
   failed (n 0: all of them, a line each), then how many there were. The exit code is that of the command,
   128 + its signal. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

/* How the file of a call is named: by its number, or by a path that is the first or second argument. */
typedef enum { BY_FILE, BY_PATH, BY_PATH_AT } Naming;

typedef struct {
  long number;
  const char *group;
  Naming naming;
} Call;

static const Call Calls[] = {
    {SYS_openat, "open", BY_PATH_AT},     {SYS_open, "open", BY_PATH},
    {SYS_creat, "open", BY_PATH},         {SYS_read, "read", BY_FILE},
    {SYS_pread64, "read", BY_FILE},       {SYS_write, "write", BY_FILE},
    {SYS_pwrite64, "write", BY_FILE},     {SYS_writev, "write", BY_FILE},
    {SYS_fsync, "sync", BY_FILE},         {SYS_fdatasync, "sync", BY_FILE},
    {SYS_close, "close", BY_FILE},        {SYS_rename, "rename", BY_PATH},
    {SYS_renameat, "rename", BY_PATH_AT}, {SYS_renameat2, "rename", BY_PATH_AT},
    {SYS_ftruncate, "truncate", BY_FILE}, {SYS_truncate, "truncate", BY_PATH},
};

typedef struct {
  const char *folder, *calls;
  int error; /* errno; 0: a short write */
  long n, seen;
  FILE *log;
} Fault;

/* A thread between the two stops of a call. */
typedef struct {
  pid_t id;
  int inside, failing;
} Thread;

enum { THREADS = 64 };
static Thread Threads[THREADS];

static Thread *thread_of(pid_t id)
{
  for (int i = 0; i < THREADS; i++) {
    if (!Threads[i].id) Threads[i].id = id;
    if (Threads[i].id == id) return Threads + i;
  }
  fprintf(stderr, "fail_call: more than %d threads\n", THREADS);
  exit(99);
}

static const Call *call_of(const struct user_regs_struct *r)
{
  for (size_t i = 0; i < sizeof(Calls) / sizeof(*Calls); i++)
    if ((long)r->orig_rax == Calls[i].number) return Calls + i;
  return NULL;
}

static void read_text(pid_t id, unsigned long long at, char text[PATH_MAX])
{
  const struct iovec here = {text, PATH_MAX - 1}, there = {(void *)(size_t)at, PATH_MAX - 1};
  const ssize_t n = process_vm_readv(id, &here, 1, &there, 1, 0);
  text[n < 0 ? 0 : n] = 0;
}

/* The file of a call, as an absolute path; "" where there is none. */
static void path_of(pid_t id, const Call *call, const struct user_regs_struct *r, char path[2 * PATH_MAX])
{
  char link[64], text[PATH_MAX] = "";
  if (call->naming == BY_FILE) {
    snprintf(link, sizeof(link), "/proc/%d/fd/%d", id, (int)r->rdi);
    const ssize_t n = readlink(link, path, PATH_MAX - 1);
    path[n < 0 ? 0 : n] = 0;
    return;
  }
  read_text(id, call->naming == BY_PATH ? r->rdi : r->rsi, text);
  if (text[0] == '/') {
    snprintf(path, 2 * PATH_MAX, "%s", text);
    return;
  }
  snprintf(link, sizeof(link), "/proc/%d/cwd", id);
  const ssize_t n = readlink(link, path, PATH_MAX - 1);
  path[n < 0 ? 0 : n] = 0;
  strcat(strcat(path, "/"), text); // both are shorter than PATH_MAX
}

/* Whether this call is the one; counts those of its kind. */
static int is_the_one(pid_t id, Fault *fault, const struct user_regs_struct *r)
{
  char path[2 * PATH_MAX];
  const Call *call = call_of(r);
  if (!call || (strcmp(fault->calls, "all") && strcmp(fault->calls, call->group))) return 0;
  if (!fault->error && strcmp(call->group, "write")) return 0;
  path_of(id, call, r, path);
  if (strncmp(path, fault->folder, strlen(fault->folder))) return 0;
  const int wanted = ++fault->seen == fault->n;
  if (wanted || !fault->n) fprintf(fault->log, "%s %s\n", call->group, path + strlen(fault->folder));
  return wanted;
}

static void at_call(pid_t id, Fault *fault)
{
  Thread *t = thread_of(id);
  struct user_regs_struct r;
  if (ptrace(PTRACE_GETREGS, id, NULL, &r)) return;
  t->inside = !t->inside;
  if (t->inside) {
    t->failing = is_the_one(id, fault, &r);
    if (!t->failing) return;
    if (fault->error)
      r.orig_rax = (unsigned long long)-1; // no call
    else if (r.rdx > 1)
      r.rdx /= 2;
  } else if (t->failing && fault->error) {
    r.rax = (unsigned long long)-(long long)fault->error;
  } else {
    return;
  }
  ptrace(PTRACE_SETREGS, id, NULL, &r);
}

/* Until the first process has ended: its code. */
static int watch(pid_t first, Fault *fault)
{
  int status, code = 99;
  for (pid_t id; (id = waitpid(-1, &status, __WALL)) > 0;) {
    int signal = 0;
    if (WIFEXITED(status) || WIFSIGNALED(status)) {
      if (id == first) code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      thread_of(id)->id = 0;
      continue;
    }
    if (WSTOPSIG(status) == (SIGTRAP | 0x80))
      at_call(id, fault);
    else if (status >> 16 == 0 && WSTOPSIG(status) != SIGSTOP && WSTOPSIG(status) != SIGTRAP)
      signal = WSTOPSIG(status);
    ptrace(PTRACE_SYSCALL, id, NULL, signal);
  }
  return code;
}

int main(int argc, char **argv)
{
  static const struct {
    const char *name;
    int error;
  } failures[] = {{"EIO", EIO}, {"ENOSPC", ENOSPC}, {"EDQUOT", EDQUOT}, {"SHORT", 0}};
  char folder[PATH_MAX];
  Fault fault = {.error = -1};
  if (argc < 7 || !realpath(argv[1], folder)) {
    fprintf(stderr, "usage: fail_call folder calls failure n log command ...\n");
    return 99;
  }
  fault.folder = strcat(folder, "/"), fault.calls = argv[2], fault.n = atol(argv[4]);
  for (int i = 0; i < 4; i++)
    if (!strcmp(argv[3], failures[i].name)) fault.error = failures[i].error;
  fault.log = fopen(argv[5], "we");
  if (fault.error < 0 || !fault.log) return 99;
  const pid_t child = fork();
  if (!child) {
    ptrace(PTRACE_TRACEME, 0, NULL, NULL);
    raise(SIGSTOP);
    execvp(argv[6], argv + 6);
    _exit(99);
  }
  waitpid(child, NULL, 0);
  ptrace(PTRACE_SETOPTIONS, child, NULL,
         PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_TRACEFORK | PTRACE_O_TRACEVFORK |
             PTRACE_O_EXITKILL);
  ptrace(PTRACE_SYSCALL, child, NULL, NULL);
  const int code = watch(child, &fault);
  fprintf(fault.log, "%ld calls\n", fault.seen);
  fclose(fault.log);
  return code;
}
