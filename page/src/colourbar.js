// The colour bar: the scene's own map, with round ticks in the unit that reads best.
import { byId, element, setText } from "./dom.js";
import { fixed, placesOf, significant, ticks, unitFor } from "./format.js";
import { CalmRange } from "./autorange.js";
import { MAP_OF, mapGradient } from "./scene/colours.js";
import { THEMES } from "./scene/theme.js";

const NAMES = { pressure: "Pressure", deformation: "Deformation", uncertainty: "Uncertainty", taxels: "Readings" };

const USUAL = { Pa: 1e4, relative: 1e4, m: 1e-4 }; // reaches of a light touch

export class ColourBar {
  #calm = new CalmRange();
  #quantity = null;
  #unit = "";
  #drawn = "";
  #ground = null;
  #changed;
  #auto = byId("range-auto");
  #hi = byId("range-hi");
  #shown = { label: "", factor: 1 };

  /** @param {({lo, hi, map}) => void} changed is told of every new range, in SI */
  constructor(changed) {
    this.#changed = changed;
    this.#auto.addEventListener("change", () => this.#switch());
    this.#hi.addEventListener("input", () => this.#draw());
  }

  /** Begin anew, as with another skin. */
  reset() {
    this.#quantity = null;
    this.#calm.reset();
  }

  /** With the colours of another theme. */
  recolour(name) {
    this.#ground = THEMES[name];
    this.#drawn = "";
    this.#draw();
  }

  /** Follow an update of the time now, s. */
  follow({ quantity, unit, range }, now) {
    if (quantity !== this.#quantity || (unit ?? "") !== this.#unit) {
      this.#quantity = quantity;
      this.#unit = unit ?? "";
      this.#calm.reset(USUAL[unit]);
      if (!this.#auto.checked) this.#auto.checked = true; // another quantity: another range
      this.#switch();
    }
    this.#calm.follow(Array.isArray(range) ? range : [], now);
    this.#draw();
  }

  #range() {
    const [lo, hi] = this.#calm.value;
    const fixedHi = Number(this.#hi.value) * this.#shown.factor;
    return this.#auto.checked || !(fixedHi > 0) ? [lo, hi] : [Math.min(lo, 0), fixedHi];
  }

  #switch() {
    this.#hi.disabled = this.#auto.checked;
    this.#drawn = "";
    this.#draw();
  }

  #draw() {
    const [lo, hi] = this.#range();
    const map = MAP_OF[this.#quantity] ?? "viridis";
    const key = `${lo} ${hi} ${map} ${this.#unit} ${this.#auto.checked}`;
    if (key === this.#drawn) return;
    this.#drawn = key;
    if (this.#auto.checked) this.#shown = unitFor(hi, this.#unit);
    const { factor, label } = this.#shown;
    byId("colour-map").style.background = mapGradient(map, "to right", this.#ground);
    const values = ticks(lo / factor, hi / factor, 5);
    const places = placesOf(values[1] - values[0]);
    byId("colour-ticks").replaceChildren(
      ...values.map((value) => tick(fixed(value, places), (value * factor - lo) / (hi - lo))),
    );
    setText(byId("range-unit"), label || "–");
    setText(byId("colour-name"), `${NAMES[this.#quantity] ?? ""}${label ? `, ${label}` : ""}`);
    if (this.#auto.checked) this.#hi.value = Number((hi / factor).toPrecision(6));
    const words = `${NAMES[this.#quantity] ?? "Colour bar"} from ${[lo, hi].map((value) => significant(value / factor)).join(" to ")} ${label}`;
    byId("colour-bar").setAttribute("aria-label", words);
    this.#changed({ lo, hi, map });
  }
}

function tick(text, at) {
  const mark = element("span", { text });
  mark.style.left = `${100 * at}%`;
  if (at < 0.03) mark.className = "first";
  if (at > 0.97) mark.className = "last";
  return mark;
}
