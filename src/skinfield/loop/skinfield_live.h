/* Reads a running skin from C or C++: contacts in newtons and metres, cycle by cycle.
 *
 *   cc -O2 -I"$(python -c 'import skinfield.loop as loop; print(loop.include_folder())')" own.c
 *
 * Version 3 of what `skinfield run` publishes, on top of skinfield_ring.h, which copies whole slots
 * and reads the log. Nothing here allocates, waits for the engine or can disturb it. All numbers
 * are SI units. Functions return 0 or a negative errno, unless they say otherwise. */
#ifndef SKINFIELD_LIVE_H
#define SKINFIELD_LIVE_H

#if defined(__has_include)
#if __has_include(<skinfield_ring.h>)
#include <skinfield_ring.h>
#else
#include "../ring/skinfield_ring.h"
#endif
#else
#include "../ring/skinfield_ring.h"
#endif
#include <stddef.h>

enum { SKINFIELD_LIVE_VERSION = 4 };
enum { /* how a patch was answered */
    SKINFIELD_MISSING = 0,  /* no reading that is young enough: nothing is known */
    SKINFIELD_IDLE = 1,     /* nothing stands out of the noise */
    SKINFIELD_LINEAR = 2,   /* by a linear solver, or the start of an iterative one */
    SKINFIELD_FEASIBLE = 3, /* a pressure field by an iterative solver, with its gap */
    SKINFIELD_CONTACTS = 4  /* few contacts that explain the readings */
};
enum { /* bits of head[SKINFIELD_HEAD_FLAGS] */
    SKINFIELD_LATE = 2,     /* ready after its deadline */
    SKINFIELD_OVERRUN = 4,  /* ready after the next one was due */
    SKINFIELD_RESTARTED = 8 /* the first of an engine that was started again */
};
enum { /* numbers of a cycle, by their place in `head`; times in ns */
    SKINFIELD_HEAD_FLAGS = 0,
    SKINFIELD_HEAD_DUE_NS = 1,      /* CLOCK_MONOTONIC: when it should have begun */
    SKINFIELD_HEAD_WAKE_NS = 2,     /* when it began */
    SKINFIELD_HEAD_ACQUIRED_NS = 3, /* when all readings that waited were taken in */
    SKINFIELD_HEAD_READY_NS = 4,    /* when the answer was complete */
    SKINFIELD_HEAD_WALL_NS = 5,     /* since the epoch, when it began */
    SKINFIELD_HEAD_LOG_POSITION = 6,/* bytes of the log that were applied */
    SKINFIELD_HEAD_MESSAGES = 7,    /* taken in */
    SKINFIELD_HEAD_FRESH = 8,       /* patches with a new reading */
    SKINFIELD_HEAD_CONTACTS = 9,    /* on all patches */
    SKINFIELD_HEAD_BUDGET_NS = 10,  /* that the reconstruction had; 0 of a replay */
    SKINFIELD_HEAD_GENERATION = 11, /* of the engine's process: 1 for the first */
    SKINFIELD_HEAD_NUMBERS = 12
};

typedef struct {
    int64_t track;         /* lasts as long as the contact does */
    int32_t patch;         /* its number, by the order in the description */
    int32_t cells;         /* nodes of the grid that it covers */
    double position[3];    /* m, in the patch's frame */
    double normal[3];      /* of the skin there, outwards; length 1 */
    double x, y;           /* m, in the patch's plane */
    double normal_force;   /* N */
    double force_std;      /* N; NaN: not known */
    double place_std;      /* m; NaN: not known */
    double area;           /* m2 */
    double peak_pressure;  /* Pa */
    double moments[3];     /* m2: second moments xx, yy, xy of the pressure */
    double age;            /* s since it was first seen */
    double speed;          /* m/s */
    int32_t shape;         /* of what presses: 0 other, 1 sphere, 2 flat, 3 line */
    int32_t maybe;         /* contacts in its place that explain the readings nearly as well: 2,
                              or 1 of two that may be one; 0: its number is sure */
    double radius;         /* m: of the contact, or of the circle of equal area */
    double covariance[6];  /* of x, y and the force: xx, xy, yy m2, xF, yF m N, FF N2; or NaN */
    double area_std;       /* m2; NaN: not known */
    double shear[3];       /* N, in the patch's frame: force onto the skin along it */
    double shear_covariance[3]; /* N2: xx, xy, yy in the patch's plane; NaN: not known */
} skinfield_contact;

typedef struct {
    int32_t answer;        /* SKINFIELD_MISSING ... */
    int32_t rung;          /* nodes along the sides of its grid; 0: none */
    int32_t fresh;         /* taxels read since the cycle before; 0: an earlier answer */
    int32_t invalid;       /* taxels that were left out */
    int32_t iterations;
    int32_t contacts;
    double gap;            /* relative duality gap; NaN: not known */
    int64_t stamp_ns;      /* of its newest reading, since the epoch; 0: none yet */
    int64_t answered_ns;   /* since the epoch */
    double force;          /* N, along the normals, of all its contacts */
    double peak_pressure;  /* Pa */
    int64_t tracks;        /* contacts numbered so far, on the whole skin */
    int64_t readings;      /* that were averaged, as nothing moved */
} skinfield_patch;

typedef char skinfield_contact_is_280_bytes_[sizeof(skinfield_contact) == 280 ? 1 : -1];
typedef char skinfield_contact_place_[offsetof(skinfield_contact, position) == 16 &&
                                      offsetof(skinfield_contact, normal_force) == 80 &&
                                      offsetof(skinfield_contact, speed) == 152 &&
                                      offsetof(skinfield_contact, area_std) == 224 ? 1 : -1];
typedef char skinfield_patch_is_80_bytes_[sizeof(skinfield_patch) == 80 ? 1 : -1];
typedef char skinfield_patch_place_[offsetof(skinfield_patch, gap) == 24 &&
                                    offsetof(skinfield_patch, tracks) == 64 ? 1 : -1];

typedef struct {
    skinfield_ring ring;
    uint64_t patches;      /* of the skin */
    uint64_t rows;         /* contacts told of each patch, at most */
    uint64_t head_at, patches_at, contacts_at; /* bytes from the beginning of a slot */
} skinfield_live;

typedef struct {
    uint64_t number;       /* of the cycle */
    int64_t head[SKINFIELD_HEAD_NUMBERS];
    uint64_t contacts;     /* that there are; not more of them are copied than there is room */
} skinfield_cycle;

static inline int skinfield_live_fields_(skinfield_live *live)
{
    static const char version[] = "{\"skinfield_live\": 4,";
    const skinfield_ring *ring = &live->ring;
    skinfield_field head, patches, contacts;
    if (ring->description_bytes < sizeof version ||
        memcmp(ring->data + ring->description, version, sizeof version - 1) != 0 ||
        skinfield_ring_field(ring, "head", &head) != 0 ||
        skinfield_ring_field(ring, "patches", &patches) != 0 ||
        skinfield_ring_field(ring, "contacts", &contacts) != 0)
        return -EPROTO;
    live->patches = patches.bytes / sizeof(skinfield_patch);
    if (live->patches == 0 || head.bytes != 8 * SKINFIELD_HEAD_NUMBERS ||
        patches.bytes % sizeof(skinfield_patch) != 0 ||
        contacts.bytes % (live->patches * sizeof(skinfield_contact)) != 0)
        return -EPROTO;
    live->rows = contacts.bytes / (live->patches * sizeof(skinfield_contact));
    live->head_at = head.offset;
    live->patches_at = patches.offset;
    live->contacts_at = contacts.offset;
    return 0;
}

static inline void skinfield_live_close(skinfield_live *live)
{
    skinfield_ring_close(&live->ring);
}

/* Opens a skin by the name that `skinfield run --name` was given, "skin" if none was.
 * -ENOENT: none runs. -EPROTO: a ring of something else, or of another version. */
static inline int skinfield_live_open(skinfield_live *live, const char *name)
{
    int problem = skinfield_ring_open(&live->ring, name);
    if (problem)
        return problem;
    problem = skinfield_live_fields_(live);
    if (problem)
        skinfield_live_close(live);
    return problem;
}

/* Waits for a cycle after `after`, at most `seconds`; returns the newest number. */
static inline uint64_t skinfield_live_wait(const skinfield_live *live, uint64_t after,
                                           double seconds)
{
    return skinfield_ring_wait(&live->ring, after, seconds);
}

/* Whether the engine answers, and was at work within so many seconds: 1 or 0. */
static inline int skinfield_live_runs(const skinfield_live *live, double seconds)
{
    double heartbeat = 1e-9 * (double)skinfield_ring_heartbeat(&live->ring);
    return skinfield_ring_state(&live->ring) == SKINFIELD_RING_RUNNING &&
           skinfield_now_() - heartbeat <= seconds;
}

/* Contacts of one slot as it lies in memory, which the writer may be changing. */
static inline uint64_t skinfield_contacts_(const skinfield_live *live, const uint8_t *slot,
                                           skinfield_contact *contacts, uint64_t room)
{
    const uint8_t *rows = slot + live->contacts_at;
    uint64_t patch, there = 0;
    for (patch = 0; patch < live->patches; patch++) {
        uint64_t at = live->patches_at + patch * sizeof(skinfield_patch), count, copied;
        int32_t told;
        memcpy(&told, slot + at + offsetof(skinfield_patch, contacts), sizeof told);
        count = told < 0 ? 0 : (uint64_t)told < live->rows ? (uint64_t)told : live->rows;
        copied = there >= room ? 0 : count < room - there ? count : room - there;
        if (copied)
            memcpy(contacts + there, rows + patch * live->rows * sizeof(skinfield_contact),
                   (size_t)(copied * sizeof(skinfield_contact)));
        there += count;
    }
    return there;
}

/* Copies the newest cycle: its numbers, `room` contacts at most, and live->patches rows of
 * `patches` unless that is NULL. Room for live->patches * live->rows contacts is always enough.
 * -ENODATA: none yet. -EAGAIN: overtaken by the writer every time; then nothing is right. */
static inline int skinfield_live_latest(const skinfield_live *live, skinfield_cycle *cycle,
                                        skinfield_contact *contacts, uint64_t room,
                                        skinfield_patch *patches)
{
    const skinfield_ring *ring = &live->ring;
    int tries;
    for (tries = 0; tries < 64; tries++) {
        uint64_t number = skinfield_ring_head(ring);
        uint64_t at = ring->slots + number % ring->slot_count * ring->slot_bytes;
        const uint8_t *slot = ring->data + at;
        if (number == 0)
            return -ENODATA;
        if (skinfield_word_(ring, at) != 2 * number + 2)
            continue;
        memcpy(cycle->head, slot + live->head_at, sizeof cycle->head);
        cycle->contacts = skinfield_contacts_(live, slot, contacts, room);
        if (patches)
            memcpy(patches, slot + live->patches_at,
                   (size_t)(live->patches * sizeof(skinfield_patch)));
        cycle->number = number;
        __atomic_thread_fence(__ATOMIC_ACQUIRE); /* copied before the lock is looked at again */
        if (skinfield_word_(ring, at) == 2 * number + 2)
            return 0;
    }
    return -EAGAIN;
}

#endif
