/**
 * What a picture is measured by, in its lower left corner: the axes of the skin with their names,
 * which of them leads out of it, and a ruler.
 */

import * as THREE from "three";
import { fixed } from "../format.js";
import { lengthWords, rulerLength } from "./ruler.js";

const ARM = 30; // px
const AT = { x: 44, y: 50 }; // of the axes' origin, px from the corner
const LONGEST = 140; // px of the ruler

const AXES = [
  { name: "x", along: [1, 0, 0], colour: { dark: "#ff6369", light: "#cd2b31" } },
  { name: "y", along: [0, 1, 0], colour: { dark: "#4cc38a", light: "#18794e" } },
  { name: "z", along: [0, 0, 1], colour: { dark: "#849dff", light: "#3451b2" } },
];

export class Corner {
  /** @param {import("./theme.js").Theme} theme */
  setTheme(theme) {
    this.ink = new THREE.Color(theme.ink);
    this.text = theme.ink;
    const name = theme.bright ? "light" : "dark";
    this.axes = AXES.map(({ colour, ...axis }) => ({
      ...axis,
      text: colour[name],
      tint: new THREE.Color(colour[name]),
    }));
  }

  /**
   * @param {import("./camera.js").OrbitCamera} view
   * @param {import("./lines.js").Lines} lines above all else
   * @param {object[]} wanted labels
   * @param {number} ruling m, side of the squares on the skin
   * @param {number} times how much deeper than real its dents are drawn
   */
  draw(view, lines, wanted, ruling, times) {
    if (view.height < 200) return;
    this.#triad(view, lines, wanted);
    this.#ruler(view, lines, wanted, `squares of ${lengthWords(ruling)}, depth ×${fixed(times, times < 9.95 ? 1 : 0)}`);
  }

  #triad(view, lines, wanted) {
    const origin = view.at(AT.x, view.height - AT.y);
    const long = ARM * view.pixel(view.distance);
    const toCamera = view.out();
    // The one that points at the viewer most is drawn last: over the others
    const depth = ({ along }) => toCamera.dot(new THREE.Vector3(...along));
    for (const axis of [...this.axes].sort((a, b) => depth(a) - depth(b))) {
      const end = new THREE.Vector3(...axis.along).multiplyScalar(long).add(origin);
      lines.add(origin.toArray(), end.toArray(), axis.tint, { width: 2.5 });
      const beyond = end.clone().sub(origin).multiplyScalar(1.32).add(origin).project(view.camera);
      const title = axis.name === "z" ? `z ${view.upright ? "up" : "out"}` : axis.name;
      wanted.push({
        key: `axis ${axis.name}`,
        title: view.zUp ? title : axis.name,
        plain: axis.text,
        middle: [(beyond.x + 1) * 0.5 * view.width, (1 - beyond.y) * 0.5 * view.height],
      });
    }
  }

  #ruler(view, lines, wanted, words) {
    const pixel = view.pixel(view.distance);
    const length = rulerLength(LONGEST * pixel);
    const [left, y] = [AT.x + ARM + 34, view.height - 31];
    const right = left + length / pixel;
    const line = (ax, ay, bx, by) =>
      lines.add(view.at(ax, ay).toArray(), view.at(bx, by).toArray(), this.ink, { width: 2 });
    line(left, y, right, y);
    line(left, y - 4, left, y + 4);
    line(right, y - 4, right, y + 4);
    wanted.push({
      key: "ruler",
      title: lengthWords(length),
      plain: this.text,
      left: [right + 4, y],
    });
    wanted.push({
      key: "ruling",
      title: words,
      plain: this.text,
      faint: true,
      left: [left - 4, y + 17],
    });
  }
}
