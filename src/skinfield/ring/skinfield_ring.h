/* Reads a skinfield ring from C or C++, without any library; Linux and other little-endian POSIX.
 *
 *   cc -O2 -I"$(python -c 'import skinfield.ring as r; print(r.include_folder())')" reader.c
 *
 * The file is mapped for reading only, so nothing here can disturb the writer or make it wait.
 * The layout, version 1, is little-endian; all offsets are bytes.
 *
 *   file      0 "SKINFLD\0"   8 u32 version      12 u32 header bytes   16 u64 file bytes
 *            24 u64 table of fields   32 u64 fields of a slot   40 u64 fields of the status
 *            48 u64 description (JSON)  56 u64 its bytes   64 u64 status   72 u64 its bytes
 *            80 u64 slots   88 u64 bytes of a slot   96 u64 how many slots
 *           104 u64 log    112 u64 its bytes, a power of two   120 u64 made, ns since the epoch
 *           128 u64 head: newest complete slot, 0 = none
 *           192 u32 futex: the lower half of head; wait on it with FUTEX_WAIT, not private
 *           256 u64 log end: bytes ever appended; always the end of a batch
 *           264 u64 log reserved: bytes that may have been written, at least log end
 *           320 i64 heartbeat, ns of CLOCK_MONOTONIC
 *           384 u32 process   388 u32 state   392 u32 generation
 *           512 64 x u64 marks: the first end of a batch in each of the newest 64ths of the log
 *   field     0 char name[48]  48 char type[8] ("<f8" as in NumPy)  56 u64 offset  64 u64 bytes
 *            72 u64 dimensions  80 u64 shape[6]; 128 bytes each, first slots', then the status'
 *   slot      0 u64 lock: 2 n + 1 while slot n is written, 2 n + 2 when it is complete
 *             8 u64 log end then   16 u64 generation of its writer   64 the fields
 *   Slot n is at index n modulo the number of slots; byte p of the log at p modulo its size.
 *
 * The log is read by skinfield_ring_log.h. Needs the __atomic built-ins of GCC and Clang.
 * Functions return 0 or a negative errno, unless they say otherwise. */
#ifndef SKINFIELD_RING_H
#define SKINFIELD_RING_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE 1
#endif
#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#ifdef __linux__
#include <linux/futex.h>
#include <sys/syscall.h>
#endif

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "a skinfield ring can only be read on a little-endian machine"
#endif

enum { SKINFIELD_RING_VERSION = 1 };
enum { /* what the writer says that it is doing */
    SKINFIELD_RING_STARTING = 0, SKINFIELD_RING_CALIBRATING = 1, SKINFIELD_RING_RUNNING = 2,
    SKINFIELD_RING_STOPPED = 3, SKINFIELD_RING_FAILED = 4
};

typedef struct {
    const uint8_t *data; /* the whole file */
    uint64_t size;
    uint64_t table, slot_fields, status_fields;
    uint64_t description, description_bytes; /* JSON; no zero behind it */
    uint64_t status, status_bytes;
    uint64_t slots, slot_bytes, slot_count;
    uint64_t log, log_bytes;
} skinfield_ring;

typedef struct {
    char name[48];
    char type[8];       /* as in NumPy: "<f8", "<f4", "<i8", "|u1", "|b1" ... */
    uint64_t offset;    /* from the beginning of the slot, or of the status */
    uint64_t bytes;
    uint64_t dimensions;
    uint64_t shape[6];
} skinfield_field;

static inline uint64_t skinfield_word_(const skinfield_ring *ring, uint64_t offset)
{
    return __atomic_load_n((const uint64_t *)(const void *)(ring->data + offset),
                           __ATOMIC_ACQUIRE);
}

static inline int skinfield_inside_(uint64_t start, uint64_t bytes, uint64_t end)
{
    return start <= end && bytes <= end - start;
}

static inline int skinfield_valid_(skinfield_ring *ring)
{
    const uint8_t *data = ring->data;
    uint64_t words[16], most = (uint64_t)1 << 40, entries;
    uint32_t version;
    memcpy(words, data, sizeof words);
    memcpy(&version, data + 8, sizeof version);
    if (memcmp(data, "SKINFLD", 8) != 0 || version != SKINFIELD_RING_VERSION)
        return -EPROTO;
    ring->table = words[3];
    ring->slot_fields = words[4];
    ring->status_fields = words[5];
    ring->description = words[6];
    ring->description_bytes = words[7];
    ring->status = words[8];
    ring->status_bytes = words[9];
    ring->slots = words[10];
    ring->slot_bytes = words[11];
    ring->slot_count = words[12];
    ring->log = words[13];
    ring->log_bytes = words[14];
    if (words[2] != ring->size || ring->size > most || ring->slot_fields > 1024 ||
        ring->status_fields > 1024)
        return -EPROTO;
    entries = 128 * (ring->slot_fields + ring->status_fields);
    if (ring->table < 4096 || !skinfield_inside_(ring->table, entries, ring->description) ||
        !skinfield_inside_(ring->description, ring->description_bytes, ring->status) ||
        !skinfield_inside_(ring->status, ring->status_bytes, ring->slots) ||
        !skinfield_inside_(ring->log, ring->log_bytes, ring->size) || ring->slots > ring->log)
        return -EPROTO;
    if (ring->slot_count < 2 || ring->slot_bytes < 64 ||
        ring->slot_bytes > (ring->log - ring->slots) / ring->slot_count ||
        (ring->status | ring->slots | ring->slot_bytes | ring->log) % 64 != 0 ||
        ring->log_bytes < 4096 || (ring->log_bytes & (ring->log_bytes - 1)) != 0)
        return -EPROTO;
    return 0;
}

static inline void skinfield_ring_close(skinfield_ring *ring)
{
    if (ring->data)
        munmap((void *)(uintptr_t)ring->data, (size_t)ring->size);
    ring->data = NULL;
}

/* Opens the ring of that name, or at that path. -EPROTO: no ring, or of another version. */
static inline int skinfield_ring_open(skinfield_ring *ring, const char *name)
{
    char path[4096];
    struct stat about;
    void *data;
    int problem, file;
    memset(ring, 0, sizeof *ring);
    snprintf(path, sizeof path, "%s%s", strchr(name, '/') ? "" : "/dev/shm/skinfield.", name);
    file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return -errno;
    data = MAP_FAILED;
    errno = EPROTO;
    if (fstat(file, &about) == 0 && about.st_size >= 4096)
        data = mmap(NULL, (size_t)about.st_size, PROT_READ, MAP_SHARED, file, 0);
    problem = errno;
    close(file);
    if (data == MAP_FAILED)
        return -problem;
    ring->data = (const uint8_t *)data;
    ring->size = (uint64_t)about.st_size;
    problem = skinfield_valid_(ring);
    if (problem)
        skinfield_ring_close(ring);
    return problem;
}

/* Number of the newest slot, 0 before the first. */
static inline uint64_t skinfield_ring_head(const skinfield_ring *ring)
{
    return skinfield_word_(ring, 128);
}

static inline uint64_t skinfield_ring_log_end(const skinfield_ring *ring)
{
    return skinfield_word_(ring, 256);
}

/* ns of CLOCK_MONOTONIC */
static inline int64_t skinfield_ring_heartbeat(const skinfield_ring *ring)
{
    return (int64_t)skinfield_word_(ring, 320);
}

static inline uint32_t skinfield_ring_pid(const skinfield_ring *ring)
{
    return (uint32_t)skinfield_word_(ring, 384);
}

static inline uint32_t skinfield_ring_state(const skinfield_ring *ring)
{
    return (uint32_t)(skinfield_word_(ring, 384) >> 32);
}

static inline uint32_t skinfield_ring_generation(const skinfield_ring *ring)
{
    return (uint32_t)skinfield_word_(ring, 392);
}

/* Field i, first those of a slot, then those of the status. -EPROTO: its place cannot be. */
static inline int skinfield_ring_field_at(const skinfield_ring *ring, uint64_t i,
                                          skinfield_field *field)
{
    int in_slot = i < ring->slot_fields;
    if (i >= ring->slot_fields + ring->status_fields)
        return -ENOENT;
    memcpy(field, ring->data + ring->table + 128 * i, 128);
    if (field->name[47] || field->type[7] || field->dimensions > 6 ||
        (in_slot && field->offset < 64) || field->offset % 8 != 0 ||
        !skinfield_inside_(field->offset, field->bytes,
                           in_slot ? ring->slot_bytes : ring->status_bytes))
        return -EPROTO;
    return 0;
}

/* Among the fields from `first` to before `last`, the one of that name. */
static inline int skinfield_find_(const skinfield_ring *ring, uint64_t first, uint64_t last,
                                  const char *name, skinfield_field *field)
{
    for (; first < last; first++) {
        skinfield_field found; /* not yet *field, which `name` may be part of */
        int problem = skinfield_ring_field_at(ring, first, &found);
        if (problem)
            return problem;
        if (strcmp(found.name, name) == 0) {
            *field = found;
            return 0;
        }
    }
    return -ENOENT;
}

/* Field of a slot by its name. -ENOENT: none. */
static inline int skinfield_ring_field(const skinfield_ring *ring, const char *name,
                                       skinfield_field *field)
{
    return skinfield_find_(ring, 0, ring->slot_fields, name, field);
}

/* Field of the status by its name, and where it lies: read it word by word. NULL: none. */
static inline const void *skinfield_ring_status(const skinfield_ring *ring, const char *name,
                                                skinfield_field *field)
{
    uint64_t first = ring->slot_fields;
    if (skinfield_find_(ring, first, first + ring->status_fields, name, field) != 0)
        return NULL;
    return ring->data + ring->status + field->offset;
}

/* Copies slot `number` into ring->slot_bytes bytes at `slot`; field.offset counts from there.
 * -ENODATA: it does not exist yet, or not any more; then `slot` holds nothing. */
static inline int skinfield_ring_get(const skinfield_ring *ring, uint64_t number, void *slot)
{
    uint64_t at = ring->slots + number % ring->slot_count * ring->slot_bytes;
    uint64_t whole = 2 * number + 2;
    if (number == 0 || number > skinfield_ring_head(ring) || skinfield_word_(ring, at) != whole)
        return -ENODATA;
    memcpy(slot, ring->data + at, (size_t)ring->slot_bytes);
    __atomic_thread_fence(__ATOMIC_ACQUIRE); /* the copy is made before the lock is looked at */
    return skinfield_word_(ring, at) == whole ? 0 : -ENODATA;
}

/* Copies the newest slot; returns its number, 0 before the first (or if every try was overtaken). */
static inline uint64_t skinfield_ring_latest(const skinfield_ring *ring, void *slot)
{
    int tries;
    for (tries = 0; tries < 64; tries++) {
        uint64_t number = skinfield_ring_head(ring);
        if (number == 0 || skinfield_ring_get(ring, number, slot) == 0)
            return number;
    }
    return 0;
}

static inline double skinfield_now_(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Waits until there is a slot newer than `after`, at most `seconds`; returns the newest number. */
static inline uint64_t skinfield_ring_wait(const skinfield_ring *ring, uint64_t after,
                                           double seconds)
{
    double end = skinfield_now_() + seconds;
    for (;;) {
        uint32_t seen = (uint32_t)skinfield_word_(ring, 192); /* before head, which is written first */
        uint64_t number = skinfield_ring_head(ring);
        double left = end - skinfield_now_();
        struct timespec limit;
        if (number > after || !(left > 0))
            return number;
        left = left < 0.5 ? left : 0.5;
        limit.tv_sec = 0;
        limit.tv_nsec = (long)(left * 1e9);
#ifdef __linux__
        syscall(SYS_futex, ring->data + 192, FUTEX_WAIT, seen, &limit, NULL, 0);
#else
        (void)seen;
        limit.tv_nsec = limit.tv_nsec < 500000 ? limit.tv_nsec : 500000;
        nanosleep(&limit, NULL);
#endif
    }
}

#endif
