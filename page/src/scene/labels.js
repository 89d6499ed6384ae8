/**
 * Labels: text drawn on small canvases and shown as quads of whole pixels inside the WebGL picture.
 *
 * They are not elements above the canvas: Chromium's software compositor tears a hole into the
 * picture there.
 */

import * as THREE from "three";
import { placeLabels } from "./layout.js";

const WIDTH = 300;
const HEIGHT = 46;
const FONT = 'ui-sans-serif, system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';

const VERTEX = /* glsl */ `
  uniform vec4 box;      // left, top, width, height in CSS px
  uniform vec2 screen;   // CSS px
  uniform vec2 part;     // of the canvas that is used
  varying vec2 vAt;
  void main() {
    vec2 at = box.xy + (position.xy * vec2(1.0, -1.0) + vec2(0.0, 1.0)) * box.zw;
    vAt = vec2(position.x * part.x, 1.0 - (1.0 - position.y) * part.y);
    gl_Position = vec4(at / screen * vec2(2.0, -2.0) + vec2(-1.0, 1.0), 0.0, 1.0);
  }`;

const FRAGMENT = /* glsl */ `
  uniform sampler2D text;
  varying vec2 vAt;
  void main() {
    gl_FragColor = texture2D(text, vAt);
  }`;

/**
 * @typedef {object} Wanted
 * @property {string} key the same from update to update
 * @property {string} title
 * @property {string} [aside] beside the title, in the colour `second`
 * @property {string} [second]
 * @property {string} [detail]
 * @property {string} [accent] colour of the bar at its side
 * @property {string} [plain] colour of bare text, without a card
 * @property {boolean} [faint] of less weight
 * @property {number} [anchorX] px
 * @property {number} [anchorY]
 * @property {-1|0|1|2} [side] as in layout.js
 * @property {boolean} [spare] better left out than covering anything, or standing far away
 * @property {boolean} [brief] better left out than covering anything
 * @property {[number, number]} [middle] where it stands, whatever else is there, px
 * @property {[number, number]} [left] the same, of the middle of its left border
 */

class Label {
  constructor(ratio) {
    this.canvas = document.createElement("canvas");
    this.texture = null;
    this.written = "";
    this.width = 0;
    this.height = 0;
    this.material = material();
    this.mesh = new THREE.Mesh(QUAD, this.material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 20;
    this.setRatio(ratio);
  }

  setRatio(ratio) {
    this.ratio = ratio;
    this.canvas.width = WIDTH * ratio;
    this.canvas.height = HEIGHT * ratio;
    this.written = "";
    this.texture?.dispose();
    this.texture = new THREE.CanvasTexture(this.canvas);
    this.texture.minFilter = THREE.NearestFilter;
    this.texture.magFilter = THREE.NearestFilter;
    this.texture.generateMipmaps = false;
    this.texture.premultiplyAlpha = true;
    this.material.uniforms.text.value = this.texture;
  }

  /** Writes at once: the picture says what the table says. */
  write(wanted, theme) {
    const { title, aside, detail, accent, plain } = wanted;
    const all = [title, aside, detail, accent, plain, theme.panel].join("\n");
    if (all === this.written) return;
    this.written = all;
    const pen = this.canvas.getContext("2d");
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.clearRect(0, 0, WIDTH, HEIGHT);
    if (plain) this.#bare(pen, wanted, theme);
    else this.#card(pen, wanted, theme);
    this.texture.needsUpdate = true;
  }

  /** Text that stands on the picture, with a rim of the background. */
  #bare(pen, { title, plain, faint }, theme) {
    pen.font = `${faint ? "" : "600 "}12px ${FONT}`;
    this.width = Math.min(WIDTH, Math.ceil(pen.measureText(title).width) + 8);
    this.height = 18;
    pen.textBaseline = "alphabetic";
    pen.lineJoin = "round";
    pen.lineWidth = 3;
    pen.strokeStyle = theme.background;
    pen.globalAlpha = 0.85;
    pen.strokeText(title, 4, 13.5);
    pen.globalAlpha = 1;
    pen.fillStyle = plain;
    pen.fillText(title, 4, 13.5);
  }

  #card(pen, { title, aside, second, detail, accent }, theme) {
    const big = `600 14px ${FONT}`;
    const middling = `600 12px ${FONT}`;
    const small = `12px ${FONT}`;
    pen.font = big;
    const titled = pen.measureText(title).width;
    let width = titled;
    pen.font = middling;
    if (aside) width += 10 + pen.measureText(aside).width;
    pen.font = small;
    width = Math.max(width, detail ? pen.measureText(detail).width : 0);
    // Widths in steps: a label that breathes with each digit is hard to look at
    this.width = Math.min(WIDTH, Math.ceil((width + 24) / 8) * 8);
    this.height = detail ? 42 : 26;
    pen.fillStyle = theme.panel;
    pen.strokeStyle = theme.edge;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.roundRect(0.5, 0.5, this.width - 1, this.height - 1, 6);
    pen.globalAlpha = 0.92;
    pen.fill();
    pen.globalAlpha = 1;
    pen.stroke();
    pen.fillStyle = accent;
    pen.beginPath();
    pen.roundRect(5, 6, 3, this.height - 12, 1.5);
    pen.fill();
    pen.textBaseline = "alphabetic";
    pen.fillStyle = theme.ink;
    pen.font = big;
    pen.fillText(title, 14, 18, WIDTH - 20);
    pen.font = middling;
    pen.fillStyle = second ?? theme.ink;
    if (aside) pen.fillText(aside, 24 + titled, 18, WIDTH - 28 - titled);
    pen.fillStyle = theme.muted;
    pen.font = small;
    if (detail) pen.fillText(detail, 14, 34, WIDTH - 20);
  }

  show(screen) {
    const { uniforms } = this.material;
    this.mesh.visible = !this.hidden;
    uniforms.box.value.set(Math.round(this.x), Math.round(this.y), this.width, this.height);
    uniforms.part.value.set(this.width / WIDTH, this.height / HEIGHT);
    uniforms.screen.value.copy(screen);
  }
}

const QUAD = new THREE.BufferGeometry();
QUAD.setAttribute(
  "position",
  new THREE.BufferAttribute(new Float32Array([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0]), 3),
);
QUAD.setIndex([0, 1, 2, 0, 2, 3]);

export class Labels {
  constructor() {
    this.group = new THREE.Group();
    /** @type {Map<string, Label>} */
    this.shown = new Map();
    this.spare = [];
    this.order = [];
    /** Those that stand where there is room, as they stand now. */
    this.placed = [];
    this.ratio = 1;
    this.screen = new THREE.Vector2(1, 1);
  }

  setScreen(width, height, ratio) {
    this.screen.set(width, height);
    if (ratio === this.ratio) return;
    this.ratio = ratio;
    for (const label of [...this.shown.values(), ...this.spare]) label.setRatio(ratio);
  }

  /**
   * @param {Wanted[]} wanted the more important first
   * @param {import("./layout.js").Box[]} kept places that are better not covered
   * @param {import("./theme.js").Theme} theme
   */
  set(wanted, kept, theme) {
    const keys = new Set(wanted.map(({ key }) => key));
    for (const [key, label] of this.shown) if (!keys.has(key)) this.#put(key, label);
    const placed = [];
    this.order.length = 0;
    for (const one of wanted) {
      const label = this.shown.get(one.key) ?? this.#take(one.key);
      label.write(one, theme);
      const { anchorX, anchorY, side, spare, brief, accent } = one;
      Object.assign(label, { anchorX, anchorY, side, spare, brief, accent, hidden: false });
      this.order.push(label);
      const at = one.middle ?? one.left;
      if (at) {
        label.x = at[0] - (one.middle ? label.width / 2 : 0);
        label.y = at[1] - label.height / 2;
        kept.push(label);
      } else placed.push(label);
    }
    placeLabels(placed, kept, this.screen.x, this.screen.y);
    for (const label of this.order) label.show(this.screen);
    this.placed = placed;
  }

  #take(key) {
    const label = this.spare.pop() ?? new Label(this.ratio);
    label.taken = undefined;
    this.shown.set(key, label);
    this.group.add(label.mesh);
    return label;
  }

  #put(key, label) {
    this.shown.delete(key);
    this.group.remove(label.mesh);
    this.spare.push(label);
  }
}

function material() {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    transparent: true,
    depthTest: false,
    depthWrite: false,
    blending: THREE.CustomBlending,
    blendSrc: THREE.OneFactor,
    blendDst: THREE.OneMinusSrcAlphaFactor,
    uniforms: {
      text: { value: null },
      box: { value: new THREE.Vector4() },
      screen: { value: new THREE.Vector2(1, 1) },
      part: { value: new THREE.Vector2(1, 1) },
    },
  });
}
