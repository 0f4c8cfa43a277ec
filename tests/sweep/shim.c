/* Stands before the calls of the C library that change files, and lets one of them fail.

   Loaded with LD_PRELOAD. `fault_at` gets the memory that says which call, counted from 0, and what
   happens there; it is shared with the process that looks on. */

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

enum { NOTHING, SIGNAL, ONCE, ALWAYS, FULL };

struct fault {
  long count; /* calls so far */
  long at;    /* the call that it happens at */
  long kind;
  long what;  /* number of a signal or of an error */
  long again; /* calls until the same signal comes again, 0 for never */
  long fired; /* how often it happened */
  char call[32];
};

static struct fault *fault;

void fault_at(void *shared) { fault = shared; }

static void fired(const char *call) {
  fault->fired++;
  if (fault->fired == 1) strncpy(fault->call, call, sizeof fault->call - 1);
}

/* Whether the call is to fail. grows: it needs room on the disk. */
static int meets(const char *call, int grows) {
  if (!fault) return 0;
  long now = fault->count++;
  switch (fault->kind) {
    case SIGNAL:
      if (now != fault->at && (!fault->again || now != fault->at + fault->again)) return 0;
      fired(call);
      kill(getpid(), (int)fault->what);
      return 0;
    case ONCE:
      if (now != fault->at) return 0;
      break;
    case ALWAYS:
      if (now < fault->at) return 0;
      break;
    case FULL:
      if (now < fault->at || !grows) return 0;
      break;
    default:
      return 0;
  }
  fired(call);
  errno = (int)fault->what;
  return 1;
}

#define NEXT(name) \
  static __typeof__(name) *next; \
  if (!next) next = (__typeof__(name) *)dlsym(RTLD_NEXT, #name)

#define WRAPPED(name, grows, parameters, arguments) \
  int name parameters { \
    NEXT(name); \
    return meets(#name, grows) ? -1 : next arguments; \
  }

WRAPPED(rename, 0, (const char *a, const char *b), (a, b))
WRAPPED(renameat, 0, (int m, const char *a, int n, const char *b), (m, a, n, b))
WRAPPED(link, 1, (const char *a, const char *b), (a, b))
WRAPPED(linkat, 1, (int m, const char *a, int n, const char *b, int f), (m, a, n, b, f))
WRAPPED(symlink, 1, (const char *a, const char *b), (a, b))
WRAPPED(unlink, 0, (const char *a), (a))
WRAPPED(unlinkat, 0, (int m, const char *a, int f), (m, a, f))
WRAPPED(mkdir, 1, (const char *a, mode_t m), (a, m))
WRAPPED(mkdirat, 1, (int d, const char *a, mode_t m), (d, a, m))
WRAPPED(rmdir, 0, (const char *a), (a))
WRAPPED(fsync, 0, (int d), (d))
WRAPPED(fdatasync, 0, (int d), (d))
WRAPPED(ftruncate64, 1, (int d, off64_t l), (d, l))
WRAPPED(chmod, 0, (const char *a, mode_t m), (a, m))
WRAPPED(fchmod, 0, (int d, mode_t m), (d, m))
WRAPPED(fchmodat, 0, (int d, const char *a, mode_t m, int f), (d, a, m, f))
WRAPPED(chown, 0, (const char *a, uid_t u, gid_t g), (a, u, g))

static int is_file(int number) {
  struct stat facts;
  return number > 2 && fstat(number, &facts) == 0 && S_ISREG(facts.st_mode);
}

/* What is killed while it writes has written a part. */
static size_t part(size_t length) {
  int cut = fault && fault->kind == SIGNAL && fault->what == SIGKILL && fault->count == fault->at;
  return cut ? length / 2 : 0;
}

ssize_t write(int number, const void *data, size_t length) {
  NEXT(write);
  if (!fault || !is_file(number)) return next(number, data, length);
  if (part(length)) (void)!next(number, data, part(length));
  return meets("write", 1) ? -1 : next(number, data, length);
}

ssize_t pwrite64(int number, const void *data, size_t length, off64_t at) {
  NEXT(pwrite64);
  if (!fault || !is_file(number)) return next(number, data, length, at);
  return meets("pwrite", 1) ? -1 : next(number, data, length, at);
}

ssize_t writev(int number, const struct iovec *parts, int count) {
  NEXT(writev);
  if (!fault || !is_file(number)) return next(number, parts, count);
  return meets("writev", 1) ? -1 : next(number, parts, count);
}

#define OPENED(name, parameters, last, arguments) \
  int name parameters { \
    NEXT(name); \
    mode_t mode = 0; \
    if (flags & (O_CREAT | O_TMPFILE)) { \
      va_list rest; \
      va_start(rest, last); \
      mode = va_arg(rest, mode_t); \
      va_end(rest); \
    } \
    if ((flags & (O_CREAT | O_TRUNC)) && meets(#name, 1)) return -1; \
    return next arguments; \
  }

OPENED(open, (const char *path, int flags, ...), flags, (path, flags, mode))
OPENED(open64, (const char *path, int flags, ...), flags, (path, flags, mode))
OPENED(openat, (int d, const char *path, int flags, ...), flags, (d, path, flags, mode))
OPENED(openat64, (int d, const char *path, int flags, ...), flags, (d, path, flags, mode))
