// Which contact is which press: estimates beside the truth, where it is known.

const REACH_M = 0.03; // farther apart they are not the same

/**
 * Pair contacts with presses, nearest first, each at most once.
 * @returns {Array<{contact, truth, error_m, error_percent}>} one per contact, in their order;
 *   truth null and errors NaN where no press is near
 */
export function matched(contacts, truths) {
  const pairs = [];
  contacts.forEach((contact, i) =>
    truths.forEach((truth, j) => {
      const apart = distance(contact, truth);
      if (contact.patch === truth.patch && apart <= REACH_M) pairs.push({ i, j, apart });
    }),
  );
  pairs.sort((a, b) => a.apart - b.apart);
  const rows = contacts.map((contact) => ({ contact, truth: null, error_m: NaN, error_percent: NaN }));
  const taken = new Set();
  for (const { i, j, apart } of pairs) {
    if (rows[i].truth || taken.has(j)) continue;
    taken.add(j);
    const truth = truths[j];
    const error = truth.force > 0 ? (100 * (contacts[i].force - truth.force)) / truth.force : NaN;
    rows[i] = { contact: contacts[i], truth, error_m: apart, error_percent: error };
  }
  return rows;
}

/** Presses that no contact was found for. */
export function unfound(rows, truths) {
  const found = new Set(rows.map(({ truth }) => truth));
  return truths.filter((truth) => !found.has(truth) && truth.force > 0);
}

function distance(contact, truth) {
  return Math.hypot(contact.x - truth.x, contact.y - truth.y);
}
