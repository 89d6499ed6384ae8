// The two plots below the picture: force of each contact, latency of the estimates.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { element } from "./dom.js";
import { cssColour } from "./theme.js";
import { fixed, micros, placesOf, significant, ticks } from "./format.js";
import { Series, Slots } from "./time_series.js";

export const SLOTS = 6;
const LONGEST_S = 30;
const GONE_S = 0.3; // after which the colour of a track may go to another
const GAP_S = 1; // without a reading, over which no line is drawn
const EVERY_MS = 100; // plots are drawn this often: they must not cost updates
const FONT = '11px system-ui, "Segoe UI", Roboto, sans-serif';

/** Decades that hold both values, for the log scale of times. */
export function decades(lo, hi) {
  const from = Math.floor(Math.log10(Math.max(lo, 1e-3)));
  const to = Math.ceil(Math.log10(Math.max(hi, 1e-3)) + 1e-9);
  return [10 ** from, 10 ** Math.max(to, from + 1)];
}

export class Plots {
  #force;
  #latency;
  #forces = new Series(2 * SLOTS, LONGEST_S);
  #times = new Series(4, LONGEST_S);
  #slots = new Slots(SLOTS, GONE_S);
  #window = 10;
  #deadline = NaN;
  #drawn = 0;
  #timer = null;
  #until = null; // s, where the past is looked at
  #newest = null; // {time, pairs, times} as added
  #history = []; // of a recording: [time, forces by the contacts' keys], by time

  constructor(forceBox, latencyBox) {
    const columns = Array.from({ length: SLOTS }, (_, i) => i);
    this.#force = chart(forceBox, {
      series: [
        ...columns.map((i) => ({ stroke: slotColour(i), width: 1.75, points: alone(slotColour(i)) })),
        ...columns.map((i) => ({ stroke: slotColour(i), width: 1, dash: [3, 4] })),
      ],
      x: () => this.#span(this.#forces),
      y: (_, __, hi) => [0, Math.max(1, (hi ?? 0) * 1.1)],
      label: (values) => values.map((v, i) => fixed(v, placesOf((values[1] ?? 1) - (values[0] ?? 0)))),
      splits: (lo, hi) => ticks(lo, hi, 4),
      tip: (values) => this.#forceTip(values),
    });
    this.#latency = chart(latencyBox, {
      series: [
        { stroke: () => cssColour("--line"), width: 1.5, points: alone(() => cssColour("--line")) },
        { stroke: () => cssColour("--slot-5"), width: 1.25, points: alone(() => cssColour("--slot-5")) },
        { stroke: () => cssColour("--late"), width: 1.25, dash: [6, 4] },
        { stroke: () => cssColour("--late"), points: { show: true, size: 4, fill: () => cssColour("--late") }, paths: () => null },
      ],
      x: () => this.#span(this.#times),
      y: (_, lo, hi) => decades(lo ?? 100, hi ?? 1000),
      log: true,
      label: (values) => values.map((v) => (Math.log10(v) % 1 === 0 ? short(v) : "")),
      splits: (lo, hi) => between(lo, hi),
      tip: latencyTip,
    });
  }

  /** Colour slot of a track, for the table; -1 where none is left. */
  slotOf(track) {
    return this.#slots.of(track, this.#forces.now ?? 0);
  }

  setWindow(seconds) {
    this.#window = seconds;
    this.draw(true);
  }

  setDeadline(microseconds) {
    this.#deadline = Number.isFinite(microseconds) ? microseconds : NaN;
  }

  /** Show the past up to a time, s; null: up to now again. */
  until(time) {
    if (time === null && this.#until !== null) this.#gap();
    this.#until = time;
    this.draw(true);
  }

  /** A new theme: the colours are looked up again. */
  recolour() {
    this.#force.redraw(false, true);
    this.#latency.redraw(false, true);
  }

  clear() {
    this.#history = [];
    this.#newest = this.#until = null;
    this.#begin();
    this.draw(true);
  }

  /** What a recording holds, from which the past of wherever it is gone to is taken. */
  recall(contacts) {
    this.#history = byTime(contacts);
    if (!this.#newest) return;
    this.#begin(this.#newest.time);
    this.#push();
    this.draw(true);
  }

  /** Begin anew at a time: with what was before it, where that is known. */
  #begin(time = NaN) {
    this.#forces.clear();
    this.#times.clear();
    this.#slots.clear();
    let last = time;
    for (const [at, forces] of this.#history) {
      if (!(at > time - LONGEST_S && at < time)) continue;
      if (at - last > GAP_S) this.#forces.gap();
      this.#forces.push((last = at), this.#row(at, [...forces].map(([key, force]) => ({ contact: { key, force } }))));
    }
  }

  #row(time, pairs) {
    const row = Array(2 * SLOTS).fill(NaN);
    for (const { contact, truth } of pairs) {
      const slot = this.#slots.of(contact.key, time);
      if (slot < 0) continue;
      row[slot] = contact.force;
      if (truth) row[SLOTS + slot] = truth.force;
    }
    return row;
  }

  /** Add what an update tells: pairs of contact and truth, at a time in s. */
  add(time, pairs, { ready_us: ready, latency_us: latency, late }) {
    if (!Number.isFinite(time)) return;
    const on = time >= this.#forces.now && time <= this.#forces.now + GAP_S;
    if (this.#history.length && !on) this.#begin(time);
    else if (time < this.#forces.now) this.#slots.clear();
    else if (!on) this.#gap();
    const [whole, computing] = [latency, ready].map((value) => (value > 0 ? value : NaN)); // for logs
    this.#newest = { time, pairs, times: [whole, computing, this.#deadline, late ? computing : NaN] };
    this.#push();
    this.draw();
  }

  #push() {
    const { time, pairs, times } = this.#newest;
    this.#forces.push(time, this.#row(time, pairs));
    this.#times.push(time, times);
  }

  #gap() {
    for (const series of [this.#forces, this.#times]) series.gap();
  }

  /** Draw soon, not more often than is worth it. */
  draw(now = false) {
    const wait = now ? 0 : this.#drawn + EVERY_MS - performance.now();
    if (wait > 0) {
      this.#timer ??= setTimeout(() => this.draw(true), wait);
      return;
    }
    clearTimeout(this.#timer);
    this.#timer = null;
    this.#drawn = performance.now();
    this.#force.setData(this.#forces.length ? this.#rows(this.#forces) : blank(2 * SLOTS));
    this.#latency.setData(this.#times.length ? this.#rows(this.#times) : blank(4));
  }

  #rows(series) {
    return series.rows(this.#window + series.now - (this.#until ?? series.now));
  }

  #span(series) {
    const now = this.#until ?? series.now ?? 0;
    return [now - this.#window, now];
  }

  /** Lines of the force plot's tip: each contact, and what is known to press it. */
  #forceTip(values) {
    const shown = [];
    for (let slot = 0; slot < SLOTS; slot += 1) {
      const [force, truth] = [values[slot], values[SLOTS + slot]];
      if (force == null) continue;
      shown.push({ slot, text: `${fixed(force, 2)}${truth == null ? "" : `, truth ${fixed(truth, 2)}`}` });
    }
    return shown;
  }
}

/** [time, Map of forces by key] of each time of contacts: their times and forces by key. */
function byTime(contacts) {
  const found = new Map();
  for (const [key, [times, forces]] of Object.entries(contacts)) {
    times.forEach((time, i) => {
      if (!found.has(time)) found.set(time, new Map());
      found.get(time).set(key, forces[i]);
    });
  }
  return [...found].sort(([one], [other]) => one - other);
}

const TIMES = ["whole", "answer", "deadline"];

function latencyTip(values) {
  return TIMES.flatMap((name, i) => (values[i] == null ? [] : [{ text: `${name} ${micros(values[i])}` }]));
}

function slotColour(slot) {
  return () => cssColour(`--slot-${slot}`);
}

/** Points where a value has no neighbour to draw a line to. */
function alone(fill) {
  const filter = ({ data }, i) => {
    const values = data[i];
    const found = values.flatMap((v, k) => (v !== null && values[k - 1] == null && values[k + 1] == null ? [k] : []));
    return found.length ? found : null;
  };
  return { show: false, size: 3.5, fill, filter };
}

function blank(columns) {
  return Array.from({ length: columns + 1 }, () => []);
}

/** Values within decades at which a line of the grid goes: 1, 2, 5 times each power. */
function between(lo, hi) {
  const found = [];
  for (let power = lo; power <= hi * 1.001; power *= 10) found.push(power, 2 * power, 5 * power);
  return found.filter((value) => value <= hi * 1.001);
}

function short(value) {
  const [factor, label] = [[1e6, "M"], [1e3, "k"], [1, ""]].find(([step]) => value >= step) ?? [1, ""];
  return `${significant(value / factor, 1)}${label}`;
}

/** A uPlot that fills its box, with axes in the page's colours and time from -window to 0 s. */
function chart(box, { series, x, y, label, splits, tip, log = false }) {
  const size = () => ({ width: Math.max(box.clientWidth, 60), height: Math.max(box.clientHeight, 60) });
  const axis = {
    stroke: () => cssColour("--muted"),
    grid: { stroke: () => cssColour("--grid"), width: 1 },
    ticks: { show: false },
    font: FONT,
  };
  const plot = new uPlot(
    {
      ...size(),
      padding: [8, 10, 0, 0],
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false }, points: { size: 6 } },
      hooks: { setCursor: [(plot) => showTip(plot, tip)] },
      scales: { x: { time: false, range: x }, y: { range: y, ...(log ? { distr: 3 } : {}) } },
      series: [{}, ...series.map((each) => ({ points: { show: false }, spanGaps: false, ...each }))],
      axes: [
        {
          ...axis,
          size: 24,
          gap: 4,
          splits: (_, __, lo, hi) => fromNow(lo, hi),
          values: (u, at) => at.map((v) => `${fixed(v - u.scales.x.max, 0)}${v === at.at(-1) ? " s" : ""}`),
        },
        {
          ...axis,
          size: 40,
          gap: 6,
          splits: (_, __, lo, hi) => splits(lo, hi),
          values: (_, at) => label(at),
          ...(log ? { filter: (_, at) => at } : {}),
        },
      ],
    },
    blank(series.length),
    box,
  );
  new ResizeObserver(() => plot.setSize(size())).observe(box);
  return plot;
}

/** What the pointer is over: the time, and the values of then. */
function showTip(plot, linesOf) {
  const { idx, left } = plot.cursor;
  const box = plot.root.parentElement;
  box.querySelector(".plot-tip")?.remove();
  if (idx == null || !(left >= 0)) return;
  const lines = linesOf(plot.data.slice(1).map((column) => column[idx]));
  const time = `${fixed(plot.data[0][idx] - plot.scales.x.max, 1)} s`;
  const values = lines.map(({ slot, text }) => element("div", {}, swatch(slot), text));
  const made = element("div", { class: "plot-tip num" }, element("div", { text: time }), ...values);
  const at = plot.bbox.left / devicePixelRatio + left;
  const room = box.clientWidth - at;
  if (room < at) made.style.right = `${room + 8}px`;
  else made.style.left = `${at + 8}px`;
  box.append(made);
}

function swatch(slot) {
  if (slot === undefined) return null;
  const mark = element("i", { class: "swatch" });
  mark.style.background = `var(--slot-${slot})`;
  return mark;
}

/** Five marks of time that stand still while the curves move. */
function fromNow(lo, hi) {
  return [0, 1, 2, 3, 4, 5].map((i) => lo + (i * (hi - lo)) / 5);
}

/** What the latency plot shows, in words. */
export function latencyText(microseconds, deadline) {
  const asked = Number.isFinite(deadline) ? `, deadline ${micros(deadline)}` : "";
  return `${micros(microseconds)}${asked}`;
}
