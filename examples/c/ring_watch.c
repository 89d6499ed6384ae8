/* Prints the first number of a field of each new slot: ring_watch RING FIELD */
#include <skinfield_ring.h>

#include <stdlib.h>

int main(int count, char **words)
{
    skinfield_ring ring;
    skinfield_field field;
    uint64_t number = 0;
    char *slot;
    if (count != 3 || skinfield_ring_open(&ring, words[1]) ||
        skinfield_ring_field(&ring, words[2], &field) || strcmp(field.type, "<f8") || !field.bytes) {
        fprintf(stderr, "expected the name of a ring and of a field of its slots, of type <f8\n");
        return 1;
    }
    slot = malloc(ring.slot_bytes);
    while (skinfield_ring_state(&ring) < SKINFIELD_RING_STOPPED) {
        double value;
        if (skinfield_ring_wait(&ring, number, 1.0) <= number)
            continue; /* nothing new within a second */
        number = skinfield_ring_latest(&ring, slot);
        memcpy(&value, slot + field.offset, sizeof value);
        printf("%llu %.17g\n", (unsigned long long)number, value);
        fflush(stdout);
    }
    free(slot);
    skinfield_ring_close(&ring);
    return 0;
}
