/* Lets the n-th change of a file fail, to test that nothing is left half done. Preloaded:
 *
 *   FAIL_AT=7 FAIL_WITH=28 LD_PRELOAD=./failing_writes.so soilsig ...
 *
 * FAIL_WITH is an errno (28: disk full, 5: I/O error). All later writes fail too where FAIL_ON is
 * set, as on a disk that stays full. Standard output and standard error are left alone.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static atomic_long count;

static int fails(void)
{
    const char *at = getenv("FAIL_AT"), *with = getenv("FAIL_WITH");
    if (!at || !with)
        return 0;
    long now = atomic_fetch_add(&count, 1) + 1, wanted = atol(at);
    if (now == wanted || (now > wanted && getenv("FAIL_ON"))) {
        errno = atoi(with);
        return 1;
    }
    return 0;
}

static int is_file(int fd)
{
    struct stat now;
    return fd > 2 && fstat(fd, &now) == 0 && S_ISREG(now.st_mode);
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int fd, const void *bytes, size_t size)
{
    return is_file(fd) && fails() ? -1 : REAL(write)(fd, bytes, size);
}

ssize_t writev(int fd, const struct iovec *parts, int number)
{
    return is_file(fd) && fails() ? -1 : REAL(writev)(fd, parts, number);
}

ssize_t pwrite64(int fd, const void *bytes, size_t size, off64_t at)
{
    return is_file(fd) && fails() ? -1 : REAL(pwrite64)(fd, bytes, size, at);
}

ssize_t copy_file_range(int from, off64_t *at, int to, off64_t *place, size_t size, unsigned flags)
{
    return fails() ? -1 : REAL(copy_file_range)(from, at, to, place, size, flags);
}

int fsync(int fd)
{
    return fails() ? -1 : REAL(fsync)(fd);
}

int rename(const char *from, const char *to)
{
    return fails() ? -1 : REAL(rename)(from, to);
}

int mkdir(const char *path, mode_t mode)
{
    return fails() ? -1 : REAL(mkdir)(path, mode);
}

int open64(const char *path, int flags, ...)
{
    mode_t mode = 0;
    if (flags & (O_CREAT | O_TMPFILE)) {
        va_list more;
        va_start(more, flags);
        mode = va_arg(more, mode_t);
        va_end(more);
    }
    if ((flags & O_CREAT) && fails())
        return -1;
    return REAL(open64)(path, flags, mode);
}
