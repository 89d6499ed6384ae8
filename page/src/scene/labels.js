/**
 * Labels: text drawn on small canvases and shown as quads of whole pixels inside the WebGL picture.
 *
 * They are not elements above the canvas: Chromium's software compositor tears a hole into the
 * picture there.
 */

import * as THREE from "three";
import { placeLabels } from "./layout.js";

const WIDTH = 240;
const HEIGHT = 46;
const FONT = 'ui-sans-serif, system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif';
/** Text of a label changes at most so often, in ms: digits that flicker cannot be read. */
const CALM = 110;

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
  uniform float opacity;
  varying vec2 vAt;
  void main() {
    gl_FragColor = texture2D(text, vAt) * opacity;
  }`;

/**
 * @typedef {object} Wanted
 * @property {string} key the same from update to update
 * @property {string} title
 * @property {string} detail
 * @property {string} accent colour of the bar at its side
 * @property {number} anchorX px
 * @property {number} anchorY
 * @property {-1|0|1} side
 * @property {number} opacity
 */

class Label {
  constructor(ratio) {
    this.canvas = document.createElement("canvas");
    this.texture = null;
    this.written = "";
    this.when = -Infinity;
    this.key = "";
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
    this.when = -Infinity;
    this.texture?.dispose();
    this.texture = new THREE.CanvasTexture(this.canvas);
    this.texture.minFilter = THREE.NearestFilter;
    this.texture.magFilter = THREE.NearestFilter;
    this.texture.generateMipmaps = false;
    this.texture.premultiplyAlpha = true;
    this.material.uniforms.text.value = this.texture;
  }

  /** @returns {boolean} whether the text is as wanted */
  write(wanted, theme, now) {
    const all = `${wanted.title}\n${wanted.detail}\n${wanted.accent}\n${theme.panel}`;
    if (all === this.written) return true;
    if (now - this.when < CALM) return false;
    this.written = all;
    this.when = now;
    this.#draw(wanted, theme);
    this.texture.needsUpdate = true;
    return true;
  }

  #draw({ title, detail, accent }, theme) {
    const pen = this.canvas.getContext("2d");
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.clearRect(0, 0, WIDTH, HEIGHT);
    const big = `600 14px ${FONT}`;
    const small = `12px ${FONT}`;
    pen.font = big;
    let width = pen.measureText(title).width;
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
    pen.fillStyle = theme.muted;
    pen.font = small;
    if (detail) pen.fillText(detail, 14, 34, WIDTH - 20);
  }

  show(screen, opacity) {
    const { uniforms } = this.material;
    uniforms.box.value.set(Math.round(this.x), Math.round(this.y), this.width, this.height);
    uniforms.part.value.set(this.width / WIDTH, this.height / HEIGHT);
    uniforms.screen.value.copy(screen);
    uniforms.opacity.value = opacity;
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
   * @param {number} now ms
   * @returns {boolean} whether all show what is wanted; otherwise draw again a little later
   */
  set(wanted, kept, theme, now) {
    const keys = new Set(wanted.map(({ key }) => key));
    for (const [key, label] of this.shown) if (!keys.has(key)) this.#put(key, label);
    let current = true;
    this.order.length = 0;
    for (const one of wanted) {
      const label = this.shown.get(one.key) ?? this.#take(one.key);
      current = label.write(one, theme, now) && current;
      label.anchorX = one.anchorX;
      label.anchorY = one.anchorY;
      label.side = one.side;
      label.wantedOpacity = one.opacity;
      this.order.push(label);
    }
    placeLabels(this.order, kept, this.screen.x, this.screen.y);
    for (const label of this.order) label.show(this.screen, label.wantedOpacity);
    return current;
  }

  #take(key) {
    const label = this.spare.pop() ?? new Label(this.ratio);
    label.when = -Infinity;
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
      opacity: { value: 1 },
    },
  });
}
