// The range of the colour bar: it follows what is there, but in round steps and without haste, so
// that the same colour means the same for as long as possible.

const STEPS = [1, 2, 5, 10];
const LINGER_S = 3; // so long must less be enough before the range shrinks

/** The smallest of 1, 2, 5 × 10ⁿ that is not below `value`; 0 for 0. */
export function roundUp(value) {
  if (!(value > 0) || !Number.isFinite(value)) return 0;
  const power = 10 ** Math.floor(Math.log10(value));
  return STEPS.map((step) => step * power).find((round) => round >= value * (1 - 1e-9));
}

export class CalmRange {
  #hi = 0;
  #lo = 0;
  #largest = 0; // since the range could last have shrunk
  #since = null;

  #usual = 1;

  /** Begin anew, as with another quantity; `usual` is shown while nothing was ever there. */
  reset(usual = 1) {
    this.#usual = usual;
    this.#hi = this.#lo = this.#largest = 0;
    this.#since = null;
  }

  /** Follow a suggestion [lo, hi] of the time now, s; returns the range to show. */
  follow([lo, hi], now) {
    if (Number.isFinite(lo) && Number.isFinite(hi)) this.#grow(lo, Math.max(hi, 0), now);
    return this.value;
  }

  /** [lo, hi] as shown. */
  get value() {
    return this.#hi > this.#lo ? [this.#lo, this.#hi] : [0, this.#usual];
  }

  #grow(lo, hi, now) {
    if (lo < this.#lo) this.#lo = -roundUp(-lo);
    const wanted = roundUp(hi);
    if (wanted >= this.#hi) {
      this.#hi = wanted;
      this.#since = null;
      return;
    }
    if (this.#since === null || now < this.#since) {
      this.#since = now;
      this.#largest = 0;
    }
    this.#largest = Math.max(this.#largest, hi);
    if (now - this.#since < LINGER_S) return;
    this.#hi = roundUp(this.#largest) || this.#hi;
    this.#since = null;
  }
}
