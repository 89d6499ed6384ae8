// The newest half minute of a live skin, to look back at: updates as they came, in bounded memory.

const SECONDS = 30;
const BYTES = 32e6;

/**
 * @typedef {object} Moment
 * @property {number} time s
 * @property {object} head of the update
 * @property {Map<number, {entry: object, arrays: Array}>} parts by patch; only those that changed
 */

export class LookBack {
  /** @type {(Moment & {bytes: number})[]} */
  #kept = [];
  #base = new Map(); // parts of what is older
  #late = null; // what came while it was held, as one moment
  #bytes = 0;
  #held = false;
  #seconds;
  #most;

  /** @param {{seconds?: number, bytes?: number}} most of what is kept */
  constructor({ seconds = SECONDS, bytes = BYTES } = {}) {
    this.#seconds = seconds;
    this.#most = bytes;
  }

  get length() {
    return this.#kept.length;
  }

  get held() {
    return this.#held;
  }

  /** Seconds that are kept at most. */
  get seconds() {
    return this.#seconds;
  }

  /** Time of the oldest moment, s; NaN without any. */
  get start() {
    return this.#kept[0]?.time ?? NaN;
  }

  /** Time of the newest moment, s. */
  get end() {
    return this.#kept.at(-1)?.time ?? NaN;
  }

  /** Take in an update; while it is held, nothing old goes for what is new. */
  add(time, head, arrays, bytes = 0) {
    if (!Number.isFinite(time)) return;
    const parts = new Map((head.patches ?? []).map((entry) => [entry.i, { entry, arrays }]));
    const moment = { time, head, parts, bytes };
    if (this.#held) this.#late = this.#late ? joined(this.#late, moment) : moment;
    else this.#push(moment);
  }

  /** Keep what there is, as it is; @returns {boolean} whether there is something */
  hold() {
    this.#held = this.length > 0;
    return this.#held;
  }

  /** Go on with what came meanwhile. */
  release() {
    this.#held = false;
    if (this.#late) this.#push(this.#late);
    this.#late = null;
  }

  clear() {
    this.#kept = [];
    this.#base.clear();
    this.#late = null;
    this.#held = false;
    this.#bytes = 0;
  }

  /** Place of the newest moment that is not later than a time. */
  placeAt(time) {
    let [low, high] = [0, this.length - 1];
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (this.#kept[middle].time <= time) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** A moment with the parts of all patches, as they were then. */
  moment(place) {
    const { time, head } = this.#kept[place];
    const parts = new Map(this.#base);
    for (const each of this.#kept.slice(0, place + 1)) for (const [i, part] of each.parts) parts.set(i, part);
    return { time, head, parts };
  }

  /** Time and total force, and when each contact was there: what the strip shows. */
  outline() {
    const touches = new Map();
    for (const { time, head } of this.#kept) {
      for (const { key } of head.contacts) {
        const [begin] = touches.get(key) ?? [time];
        touches.set(key, [begin, time]);
      }
    }
    return {
      times: this.#kept.map(({ time }) => time),
      force: this.#kept.map(({ head }) => total(head.contacts)),
      touches: [...touches.values()],
    };
  }

  /** Rows of the table of contacts, each reading once. */
  rows() {
    const seen = new Set(this.#kept.flatMap(({ head }) => head.rows ?? []));
    return [...seen];
  }

  #push(moment) {
    if (this.length && moment.time < this.end) this.clear(); // another engine
    const before = this.#kept.at(-1);
    if (before?.time === moment.time) {
      this.#bytes += moment.bytes;
      this.#kept[this.length - 1] = joined(before, moment);
    } else {
      this.#kept.push(moment);
      this.#bytes += moment.bytes;
    }
    while (this.length > 1 && (this.start < this.end - this.#seconds || this.#bytes > this.#most)) {
      const { parts, bytes } = this.#kept.shift();
      for (const [i, part] of parts) this.#base.set(i, part);
      this.#bytes -= bytes;
    }
  }
}

/** Two moments as one, of the later's time. */
function joined(before, after) {
  return { ...after, parts: new Map([...before.parts, ...after.parts]), bytes: before.bytes + after.bytes };
}

/** Force of all contacts, N. */
export function total(contacts) {
  return contacts.reduce((sum, { force }) => sum + force, 0);
}
