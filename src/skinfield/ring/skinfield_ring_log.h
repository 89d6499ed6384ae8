/* Reads the log of a skinfield ring, in whole batches; for the rest see skinfield_ring.h. */
#ifndef SKINFIELD_RING_LOG_H
#define SKINFIELD_RING_LOG_H

#include "skinfield_ring.h"

typedef struct {
    uint64_t position; /* of the next byte; an end of a batch */
    uint64_t lost;     /* bytes that were overwritten before they could be read */
} skinfield_log;

/* Where a reader of the log begins that wants what is appended from now on. */
static inline skinfield_log skinfield_log_now(const skinfield_ring *ring)
{
    skinfield_log log;
    log.position = skinfield_ring_log_end(ring);
    log.lost = 0;
    return log;
}

static inline uint64_t skinfield_log_resume_(const skinfield_ring *ring, uint64_t end)
{
    uint64_t segment_bytes = ring->log_bytes / 64, i;
    uint64_t lowest = skinfield_word_(ring, 264) - ring->log_bytes + ring->log_bytes / 4;
    for (i = 1; i <= 64; i++) {
        uint64_t segment = lowest / segment_bytes + i;
        uint64_t mark = skinfield_word_(ring, 512 + 8 * (segment % 64));
        if (mark / segment_bytes == segment && mark <= end)
            return mark;
    }
    return end;
}

static inline void skinfield_log_skip_(skinfield_log *log, uint64_t position)
{
    if (position > log->position) {
        log->lost += position - log->position;
        log->position = position;
    }
}

/* Copies whole batches that have come since the last call; returns how many bytes. With a buffer as
 * large as the log, or larger than two 64ths of it and the longest batch, nothing is left out; 0 with
 * a smaller one may mean that the next batches do not fit. What was overwritten is in log->lost. */
static inline uint64_t skinfield_log_read(const skinfield_ring *ring, skinfield_log *log,
                                          void *buffer, uint64_t capacity)
{
    int tries;
    for (tries = 0; tries < 8; tries++) {
        uint64_t end = skinfield_ring_log_end(ring), stop = end, i, at, first;
        if (skinfield_word_(ring, 264) - log->position > ring->log_bytes)
            skinfield_log_skip_(log, skinfield_log_resume_(ring, end));
        if (end <= log->position)
            return 0;
        if (end - log->position > capacity) { /* at the last known end of a batch that fits */
            stop = log->position;
            for (i = 0; i < 64; i++) {
                uint64_t mark = skinfield_word_(ring, 512 + 8 * i);
                if (mark > stop && mark <= end && mark - log->position <= capacity)
                    stop = mark;
            }
        }
        if (stop - log->position > ring->log_bytes) {
            skinfield_log_skip_(log, end);
            continue;
        }
        at = log->position & (ring->log_bytes - 1);
        first = stop - log->position;
        first = first < ring->log_bytes - at ? first : ring->log_bytes - at;
        memcpy(buffer, ring->data + ring->log + at, (size_t)first);
        memcpy((uint8_t *)buffer + first, ring->data + ring->log,
               (size_t)(stop - log->position - first));
        __atomic_thread_fence(__ATOMIC_ACQUIRE);
        if (skinfield_word_(ring, 264) - log->position <= ring->log_bytes) {
            uint64_t count = stop - log->position;
            log->position = stop;
            return count;
        }
    }
    skinfield_log_skip_(log, skinfield_ring_log_end(ring));
    return 0;
}

#endif
