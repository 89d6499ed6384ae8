/* Prints where a running skin is touched, and how hard: contacts [NAME]
 *
 *   cc -O2 -I"$(python -c 'import skinfield.loop as live; print(live.include_folder())')" contacts.c -o contacts
 */
#include <skinfield_live.h>

#include <stdlib.h>

static void print_contact(const skinfield_cycle *cycle, const skinfield_contact *contact)
{
    printf("cycle %llu  contact %lld  patch %d  at %.2f %.2f %.2f mm  %.3f +- %.3f N  %.1f kPa\n",
           (unsigned long long)cycle->number, (long long)contact->track, contact->patch,
           1e3 * contact->position[0], 1e3 * contact->position[1], 1e3 * contact->position[2],
           contact->normal_force, contact->force_std, 1e-3 * contact->peak_pressure);
}

int main(int count, char **words)
{
    const char *name = count > 1 ? words[1] : "skin";
    skinfield_live live;
    skinfield_cycle cycle = {0, {0}, 0};
    skinfield_contact *contacts;
    uint64_t room, i;
    int problem = skinfield_live_open(&live, name);
    if (problem) {
        fprintf(stderr, "%s: %s; is `skinfield run` on?\n", name, strerror(-problem));
        return 1;
    }
    room = live.patches * live.rows;
    contacts = malloc(room * sizeof *contacts);
    while (contacts && skinfield_ring_state(&live.ring) < SKINFIELD_RING_STOPPED) {
        if (skinfield_live_wait(&live, cycle.number, 1.0) <= cycle.number) {
            fprintf(stderr, "no cycle within a second\n");
            continue;
        }
        if (skinfield_live_latest(&live, &cycle, contacts, room, NULL) != 0)
            continue; /* overtaken by the writer: there is a newer one */
        if (cycle.head[SKINFIELD_HEAD_FRESH] == 0)
            continue; /* no new reading: the answers of an earlier cycle */
        for (i = 0; i < cycle.contacts; i++)
            print_contact(&cycle, &contacts[i]);
        fflush(stdout);
    }
    free(contacts);
    skinfield_live_close(&live);
    return 0;
}
