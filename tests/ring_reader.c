/* What C sees of a ring, for tests/test_c_headers.py, as lines:
 *   ring_reader PATH              everything
 *   ring_reader PATH COUNT        reads until slot COUNT: whole, torn, overtaken; log: bytes, lost, wrong
 */
#include <skinfield_ring_log.h>

#include <inttypes.h>
#include <stdlib.h>

static void show_bytes(const char *what, const void *data, uint64_t count)
{
    uint64_t i;
    printf("%s ", what);
    for (i = 0; i < count; i++)
        printf("%02x", ((const uint8_t *)data)[i]);
    printf("\n");
}

static int show(const skinfield_ring *ring)
{
    uint64_t i, number, count, most = ring->log_bytes;
    uint8_t *slot = malloc(ring->slot_bytes), *bytes = malloc(most);
    skinfield_log log = {0, 0};
    skinfield_field field;
    printf("pid %" PRIu32 "\nstate %" PRIu32 "\ngeneration %" PRIu32 "\nheartbeat %" PRId64 "\n",
           skinfield_ring_pid(ring), skinfield_ring_state(ring), skinfield_ring_generation(ring),
           skinfield_ring_heartbeat(ring));
    printf("description %.*s\n", (int)ring->description_bytes, ring->data + ring->description);
    number = skinfield_ring_latest(ring, slot);
    printf("latest %" PRIu64 "\n", number);
    for (i = 0; i < ring->slot_fields + ring->status_fields; i++) {
        const void *data;
        if (skinfield_ring_field_at(ring, i, &field) != 0)
            return 2;
        printf("field %s %s %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", field.name, field.type,
               field.dimensions, field.shape[0], field.shape[1]);
        if (i < ring->slot_fields)
            data = slot + field.offset;
        else
            data = skinfield_ring_status(ring, field.name, &field);
        show_bytes(field.name, data, field.bytes);
    }
    for (i = 1; i <= number + 1; i++)
        printf("get %d\n", skinfield_ring_get(ring, i, slot));
    while ((count = skinfield_log_read(ring, &log, bytes, 1000)) > 0)
        show_bytes("log", bytes, count);
    printf("lost %" PRIu64 "\nposition %" PRIu64 "\n", log.lost, log.position);
    printf("none %d\n", skinfield_ring_field(ring, "none", &field));
    free(slot);
    free(bytes);
    return 0;
}

static int watch(const skinfield_ring *ring, uint64_t last)
{
    uint64_t *slot = malloc(ring->slot_bytes), *bytes = malloc(ring->log_bytes);
    uint64_t number = 0, whole = 0, torn = 0, overtaken = 0, taken = 0, wrong = 0, i, count;
    skinfield_log log = skinfield_log_now(ring);
    skinfield_field field;
    if (skinfield_ring_field(ring, "words", &field) != 0)
        return 2;
    printf("ready\n");
    fflush(stdout);
    while (number < last) {
        uint64_t newest = skinfield_ring_wait(ring, number, 60.0);
        if (newest <= number)
            return 3;
        number = newest;
        if (skinfield_ring_get(ring, number, slot) == 0) {
            int same = 1;
            for (i = 0; i < field.bytes / 8; i++)
                same &= slot[field.offset / 8 + i] == number;
            whole += (uint64_t)same;
            torn += (uint64_t)!same;
        } else {
            overtaken++;
        }
        count = skinfield_log_read(ring, &log, bytes, ring->log_bytes);
        for (i = 0; i < count / 8; i++)
            wrong += bytes[i] != (log.position - count) / 8 + i;
        taken += count;
    }
    printf("%" PRIu64 " %" PRIu64 " %" PRIu64 " %" PRIu64 " %" PRIu64 " %" PRIu64 "\n", whole, torn,
           overtaken, taken, log.lost, wrong);
    free(slot);
    free(bytes);
    return 0;
}

int main(int count, char **words)
{
    skinfield_ring ring;
    int problem = skinfield_ring_open(&ring, words[1]);
    if (problem) {
        printf("refused %d\n", problem);
        return 1;
    }
    problem = count > 2 ? watch(&ring, (uint64_t)atoll(words[2])) : show(&ring);
    skinfield_ring_close(&ring);
    return problem;
}
