// What the plots show: values over time, kept as long as the longest window.

/** Columns of numbers over one time axis; what is too old is dropped. */
export class Series {
  #times = [];
  #columns;
  #span;
  #first = 0; // index of the oldest that still counts

  constructor(columns, span) {
    this.#columns = Array.from({ length: columns }, () => []);
    this.#span = span;
  }

  get length() {
    return this.#times.length - this.#first;
  }

  /** Time of the newest row, s; undefined without rows. */
  get now() {
    return this.#times.at(-1);
  }

  clear() {
    this.#times = [];
    this.#columns = this.#columns.map(() => []);
    this.#first = 0;
  }

  /** Add a row, or put it in place of that of the same time; a jump back in time, or over the whole
   * span, begins anew. */
  push(time, values) {
    if (!Number.isFinite(time)) return;
    if (this.length && time === this.now) return this.#replace(values);
    if (this.length && (time < this.now || time > this.now + this.#span)) this.clear();
    this.#times.push(time);
    this.#columns.forEach((column, i) => column.push(finite(values[i])));
    while (this.#times[this.#first] < time - this.#span) this.#first += 1;
    if (this.#first > 1024) this.#drop();
  }

  /** There is nothing to draw from the newest row to the next. */
  gap() {
    if (this.length) this.push(this.now + 1e-6, []);
  }

  /** [times, column, ...] of the newest `window` seconds, as uPlot takes them. */
  rows(window) {
    let from = this.#first;
    while (this.#times[from] < this.now - window) from += 1;
    if (from > this.#first) from -= 1; // one beyond the edge: the line enters from there
    return [this.#times, ...this.#columns].map((column) => column.slice(from));
  }

  #replace(values) {
    this.#columns.forEach((column, i) => (column[column.length - 1] = finite(values[i])));
  }

  #drop() {
    this.#times.splice(0, this.#first);
    for (const column of this.#columns) column.splice(0, this.#first);
    this.#first = 0;
  }
}

function finite(value) {
  return Number.isFinite(value) ? value : null;
}

/** [from, to[ of the runs of times without a gap. */
export function unbroken(times, gap) {
  const starts = times.flatMap((time, i) => (i === 0 || time - times[i - 1] > gap ? [i] : []));
  return starts.map((from, k) => [from, starts[k + 1] ?? times.length]);
}

/** Gives each track a colour of few, the same while it is to be seen. */
export class Slots {
  #slots; // {track, seen} of each
  #linger;

  constructor(count, linger) {
    this.#slots = Array.from({ length: count }, () => ({ track: null, seen: -Infinity }));
    this.#linger = linger;
  }

  clear() {
    for (const slot of this.#slots) Object.assign(slot, { track: null, seen: -Infinity });
  }

  /** The slot of a track at a time, s; -1 where all are taken. */
  of(track, now) {
    let index = this.#slots.findIndex((slot) => slot.track === track);
    if (index < 0) index = this.#free(now);
    if (index >= 0) this.#slots[index] = { track, seen: now };
    return index;
  }

  /** The first that nobody ever had, else the one that was left longest ago. */
  #free(now) {
    let best = -1;
    this.#slots.forEach(({ track, seen }, i) => {
      const free = track === null || now - seen > this.#linger || now < seen;
      if (free && (best < 0 || seen < this.#slots[best].seen)) best = i;
    });
    return best;
  }
}
