// Images of contacts: pressure and outline of what touches, from many readings of it as it moves.
import { able } from "./controls.js";
import { byId, setText } from "./dom.js";
import { fixed, quantity } from "./format.js";
import { mapTable } from "./scene/colours.js";
import { lengthWords, roundLength } from "./scene/ruler.js";
import { THEMES } from "./scene/theme.js";

const MOST = 3; // images beside each other
const ROOM = 18; // px below an image, for its scale
const LINE = 1.8; // px

export class Shapes {
  #ask;
  #box = byId("show-shapes");
  #canvas = byId("shape-canvas");
  #theme = THEMES.dark;
  #told = null;

  /** @param {(command) => Promise<boolean>} ask */
  constructor(ask) {
    this.#ask = ask;
    this.#box.addEventListener("change", () => this.#switch());
  }

  /** Another skin, or a new connection: what was asked for is asked for again. */
  hello({ mode }) {
    able(this.#box, mode === "replay" ? "a recording has no images of contacts: they are made of a live skin" : null);
    this.show({});
    if (mode !== "replay" && this.#box.checked) this.#ask({ do: "shapes", on: true });
  }

  async #switch() {
    const on = this.#box.checked;
    this.show({});
    if (!(await this.#ask({ do: "shapes", on }))) this.#box.checked = false;
    this.show({});
  }

  recolour(name) {
    this.#theme = THEMES[name];
    this.#draw();
  }

  /** Show the images of an update; without any, what one would have to do. */
  show({ shapes }) {
    this.#told = shapes ?? null;
    byId("shape-inset").hidden = !this.#box.checked || this.#box.disabled;
    this.#draw();
  }

  #draw() {
    if (byId("shape-inset").hidden) return;
    const images = (this.#told?.images ?? []).slice(0, MOST);
    this.#canvas.hidden = images.length === 0;
    setText(byId("shape-text"), images.length ? images.map(words).join("; ") : this.#hint());
    if (!images.length) return;
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    const ratio = window.devicePixelRatio || 1;
    Object.assign(this.#canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
    const pen = this.#canvas.getContext("2d");
    pen.scale(ratio, ratio);
    const step = width / images.length;
    images.forEach((image, i) => drawImage(pen, image, { left: i * step, width: step - 4, height }, this.#theme));
    this.#canvas.setAttribute("aria-label", `Pressure of what touches: ${images.map(words).join("; ")}`);
  }

  #hint() {
    const why = this.#told?.why;
    return why ? `Shapes: ${why}` : "Press, and drag: shapes sharpen as what touches moves by a few millimetres";
  }
}

/** "96 mm², 5.0 N, convexity 0.62, of 30 readings". */
export function words({ area, force, convexity, readings, peak }) {
  const bent = Number.isFinite(convexity) ? `convexity ${fixed(convexity, 2)}, ` : "";
  return `${fixed(1e6 * area, 0)} mm², ${fixed(force, 2)} N, up to ${quantity(peak, "Pa")}, ${bent}of ${readings} reading${readings === 1 ? "" : "s"}`;
}

/** px per metre, and where x and y of the body's frame are drawn, for an image in a box. */
export function placing({ rows, columns, cell, low }, { left, width, height }) {
  const scale = Math.min(width / (columns * cell), (height - ROOM) / (rows * cell));
  const x0 = left + (width - scale * columns * cell) / 2;
  return {
    scale,
    x: (u) => x0 + scale * (u - low[0] + cell / 2),
    y: (v) => scale * (rows * cell - (v - low[1] + cell / 2)),
  };
}

function drawImage(pen, image, box, theme) {
  const { rows, columns, cell, low, bytes, outline } = image;
  const { scale, x, y } = placing(image, box);
  const table = mapTable("viridis", theme);
  const small = new OffscreenCanvas(columns, rows);
  const data = new ImageData(columns, rows);
  for (let row = 0; row < rows; row += 1) {
    for (let column = 0; column < columns; column += 1) {
      const from = 4 * bytes[row * columns + column];
      data.data.set(table.subarray(from, from + 4), 4 * ((rows - 1 - row) * columns + column));
    }
  }
  small.getContext("2d").putImageData(data, 0, 0);
  pen.imageSmoothingEnabled = true;
  const [left, top] = [x(low[0] - cell / 2), y(low[1] + (rows - 0.5) * cell)];
  pen.drawImage(small, left, top, scale * columns * cell, scale * rows * cell);
  for (const [width, colour] of [[LINE + 2, theme.casing], [LINE, theme.onSkin.contact]]) {
    pen.lineWidth = width;
    pen.strokeStyle = colour;
    pen.lineJoin = "round";
    for (const line of outline) {
      pen.beginPath();
      for (const [u, v] of line) pen.lineTo(x(u), y(v));
      pen.closePath();
      pen.stroke();
    }
  }
  drawScale(pen, left, top + scale * rows * cell, scale, columns * cell, theme);
}

/** A bar of a round length below an image, with its length in words. */
function drawScale(pen, left, foot, scale, wide, theme) {
  const long = roundLength(wide / 3);
  pen.fillStyle = theme.muted;
  pen.fillRect(left, foot + 5, scale * long, 2);
  for (const at of [0, long]) pen.fillRect(left + scale * at - 0.75, foot + 3, 1.5, 6);
  pen.font = "11px system-ui, sans-serif";
  pen.textBaseline = "middle";
  pen.fillText(lengthWords(long), left + scale * long + 6, foot + 7);
}
