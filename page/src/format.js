// Numbers as people read them: with units, and with as many digits as mean something.

const STEPS = {
  Pa: [[1e6, "MPa"], [1e3, "kPa"], [1, "Pa"]],
  m: [[1e-3, "mm"]],
  N: [[1, "N"], [1e-3, "mN"]],
  relative: [[1e3, "relative"]], // pressure that holds up to one factor
  1: [[1, "ΔC/C₀"]], // the one ratio that taxels tell
};

/**
 * The unit in which a scale that reaches `reach` reads best.
 * @returns {{label: string, factor: number}} shown = value / factor
 */
export function unitFor(reach, unit) {
  const steps = STEPS[unit] ?? [[1, unit ?? ""]];
  const size = Math.abs(reach);
  const [factor, label] = steps.find(([step]) => size >= 0.9999 * step) ?? steps.at(-1);
  return { label, factor };
}

/** A number with so many significant digits, never in exponents; "–" where there is none. */
export function significant(value, digits = 3) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const places = digits - 1 - Math.floor(Math.log10(Math.abs(value)));
  return minus(value.toFixed(Math.min(Math.max(places, 0), 8)));
}

/** A number with so many places after the point; "–" where there is none. */
export function fixed(value, places = 1) {
  if (!Number.isFinite(value)) return "–";
  const text = value.toFixed(places);
  return minus(Number(text) === 0 ? text.replace("-", "") : text);
}

/** The unit of forces; they may hold up to one factor only. */
export function forceUnit(relative) {
  return relative ? "rel." : "N";
}

/** The force of a contact and its standard deviation, as the table and the picture both show it. */
export function forceWords({ force, force_std }) {
  return `${fixed(force, 2)}${Number.isFinite(force_std) ? ` ± ${fixed(force_std, 2)}` : ""}`;
}

/** A force along the skin, its standard deviation where one is told, and its direction. */
export function shearWords({ size, std, angle }) {
  return `${forceWords({ force: size, force_std: std })} along the skin, ${fixed((180 * angle) / Math.PI, 0)}° from x`;
}

/** A quantity with its unit: quantity(0.00123, "m") is "1.23 mm". */
export function quantity(value, unit, digits = 3) {
  if (!Number.isFinite(value)) return "–";
  const { label, factor } = unitFor(value, unit);
  return `${significant(value / factor, digits)}${label ? ` ${label}` : ""}`;
}

/** µs as µs or ms: micros(1530) is "1.53 ms". */
export function micros(value) {
  if (!Number.isFinite(value)) return "–";
  if (value < 999.5) return `${fixed(value, 0)} µs`;
  return value < 999500 ? `${significant(value / 1e3)} ms` : `${significant(value / 1e6)} s`;
}

/** Seconds as on a clock: clock(75.25) is "1:15.2". */
export function clock(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const tenths = Math.floor(Math.abs(seconds) * 10 + 1e-6);
  const rest = String(Math.floor(tenths / 10) % 60).padStart(2, "0");
  const text = `${Math.floor(tenths / 600)}:${rest}.${tenths % 10}`;
  return seconds < 0 && tenths ? minus(`-${text}`) : text;
}

/** Bytes: bytes(198000) is "198 kB". */
export function bytes(value) {
  if (!Number.isFinite(value)) return "–";
  const steps = [[1e9, "GB"], [1e6, "MB"], [1e3, "kB"], [1, "B"]];
  const [factor, label] = steps.find(([step]) => value >= 0.9995 * step) ?? steps.at(-1);
  return `${significant(value / factor)} ${label}`;
}

/** A count with thin spaces between thousands. */
export function count(value) {
  if (!Number.isFinite(value)) return "–";
  return String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** Round numbers from lo to hi, about so many: ticks(0, 47, 5) is [0, 10, 20, 30, 40]. */
export function ticks(lo, hi, about = 5) {
  const span = hi - lo;
  if (!(span > 0) || !Number.isFinite(span)) return [];
  const raw = span / Math.max(about, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((m) => m * power).find((s) => s >= raw * 0.999);
  const first = Math.ceil(lo / step - 1e-6);
  const last = Math.floor(hi / step + 1e-6);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
}

/** Places after the point that tell ticks of this step apart. */
export function placesOf(step) {
  if (!(step > 0)) return 0;
  for (let places = 0; places < 8; places += 1) {
    const scaled = step * 10 ** places;
    if (Math.abs(scaled - Math.round(scaled)) < 1e-6 * scaled) return places;
  }
  return 8;
}

const BY = { contacts: "contacts explain the reading", field: "of a field", linear: "of a linear answer" };

/** How many contacts explain the readings nearly as well, as a word; "" where the number is sure. */
export function orElse(maybe) {
  return maybe ? (maybe > 1 ? "two" : "one") : "";
}

/** What presses and what it was found from, in words. */
export function contactWords({ shape, radius, maybe, answer, readings, shear }) {
  const size = Number.isFinite(radius) ? `, radius ${fixed(1e3 * radius, 1)} mm` : "";
  const words = [
    shape && shape !== "other" ? `${shape}${size}` : "",
    maybe ? `${orElse(maybe)} in the place of ${maybe > 1 ? "this one" : "two"} would explain the readings nearly as well` : "",
    shear ? shearWords(shear) : "",
    BY[answer] ?? "",
    readings > 1 ? `mean of ${readings} readings` : "",
  ];
  return words.filter(Boolean).join("; ");
}

function minus(text) {
  return text.replace("-", "−");
}
