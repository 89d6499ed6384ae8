// The strip above the time bar: total force over time, and when something began and ended to touch.
import { fixed } from "./format.js";
import { unbroken } from "./time_series.js";
import { cssColour } from "./theme.js";

const INSET = 8; // px at both ends, half the knob of the bar below
const LEAST_N = 0.5; // at its top, at the least
const MARK = 4; // px, of a touch's ends
const GAP_S = 1; // without a word, at the least: a live skin's page is told of it twice a second

export class Strip {
  #canvas;
  #shown = null;

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.#canvas = canvas;
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /** @param {{start, end, times, force, touches, unit}|null} shown s, N; touches: [begin, end] */
  show(shown) {
    this.#shown = shown;
    this.draw();
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    const ratio = window.devicePixelRatio || 1;
    Object.assign(this.#canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    const pen = this.#canvas.getContext("2d");
    pen.scale(ratio, ratio);
    if (!this.#shown || !(this.#shown.end > this.#shown.start)) return;
    const { start, end, times, force, touches, unit } = this.#shown;
    const x = (time) => INSET + ((time - start) / (end - start)) * (width - 2 * INSET);
    const top = force.reduce((most, value) => Math.max(most, value || 0), LEAST_N);
    const foot = height - MARK - 1;
    const y = (value) => foot - ((foot - 2) * value) / top;
    for (const [from, to] of unbroken(times, Math.max(GAP_S, (end - start) / 300))) {
      this.#area(pen, times.slice(from, to).map(x), force.slice(from, to).map(y), foot);
    }
    this.#marks(pen, touches, x, [start, end], foot);
    const peak = `${fixed(top, top < 10 ? 1 : 0)} ${unit ?? "N"}`;
    const many = `${touches.length} touch${touches.length === 1 ? "" : "es"}`;
    const words = `Total force over time, up to ${peak}; ${many}, marked where they begin and end`;
    if (this.#canvas.title !== words) this.#canvas.setAttribute("aria-label", (this.#canvas.title = words));
  }

  #area(pen, xs, ys, foot) {
    pen.beginPath();
    xs.forEach((at, i) => pen.lineTo(at, Number.isFinite(ys[i]) ? ys[i] : foot));
    pen.strokeStyle = cssColour("--accent");
    pen.lineWidth = 1.25;
    pen.stroke();
    pen.lineTo(xs.at(-1), foot);
    pen.lineTo(xs[0], foot);
    pen.globalAlpha = 0.22;
    pen.fillStyle = cssColour("--accent");
    pen.fill();
    pen.globalAlpha = 1;
  }

  /** Below the curve: a bar as long as each touch, with an end at each side that is in the strip. */
  #marks(pen, touches, x, [start, end], foot) {
    pen.strokeStyle = pen.fillStyle = cssColour("--waiting");
    for (const [begin, last] of touches) {
      if (last < start || begin > end) continue;
      const [from, to] = [x(Math.max(begin, start)), x(Math.min(last, end))];
      pen.fillRect(from, foot + 2, Math.max(to - from, 1), 1.5);
      for (const at of [begin, last]) if (at > start && at < end) pen.fillRect(x(at) - 0.75, foot - 1, 1.5, MARK + 2);
    }
  }
}
