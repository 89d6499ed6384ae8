/**
 * Lines of constant width in pixels, dashed or not, each with a casing that keeps it legible on any
 * colour. One buffer for all of them, written anew at every update.
 */

import * as THREE from "three";

const VERTEX = /* glsl */ `
  attribute vec3 from;
  attribute vec3 to;
  attribute vec4 tint;
  attribute vec3 style;   // width in px, where its dashes begin and end (0, 0: none)
  uniform vec2 screen;    // px
  uniform float ratio;
  varying vec2 vAt;
  varying float vLong;
  varying float vHalf;
  varying vec4 vTint;
  varying vec2 vDash;
  void main() {
    vec4 a = projectionMatrix * modelViewMatrix * vec4(from, 1.0);
    vec4 b = projectionMatrix * modelViewMatrix * vec4(to, 1.0);
    vec2 pa = a.xy / a.w * screen * 0.5;
    vec2 pb = b.xy / b.w * screen * 0.5;
    vec2 along = pb - pa;
    vLong = length(along);
    along = vLong > 1e-4 ? along / vLong : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x);
    vHalf = 0.5 * style.x * ratio;
    float reach = vHalf + 2.0 * ratio;
    vec4 end = mix(a, b, position.x);
    vec2 off = along * (position.x * 2.0 - 1.0) * reach + across * position.y * reach;
    vAt = vec2(position.x * vLong + (position.x * 2.0 - 1.0) * reach, position.y * reach);
    vTint = tint;
    vDash = style.yz;
    gl_Position = end;
    gl_Position.xy += off / screen * 2.0 * end.w;
    gl_Position.z -= 5e-4 * end.w;  // in front of the skin it lies on
  }`;

const FRAGMENT = /* glsl */ `
  uniform vec3 casing;
  uniform float below;    // 1: the casing, drawn before any line
  uniform float ratio;
  varying vec2 vAt;
  varying float vLong;
  varying float vHalf;
  varying vec4 vTint;
  varying vec2 vDash;
  void main() {
    float beyond = max(max(-vAt.x, vAt.x - vLong), 0.0);
    float away = length(vec2(beyond, vAt.y));
    if (vDash.y > vDash.x) {
      float at = mix(vDash.x, vDash.y, clamp(vAt.x / max(vLong, 1e-4), 0.0, 1.0));
      if (fract(at) > 0.55) discard;
    }
    float core = 1.0 - smoothstep(vHalf - 0.6, vHalf + 0.6, away);
    float around = 1.0 - smoothstep(vHalf + 0.4 * ratio, vHalf + 1.8 * ratio, away);
    vec4 colour = below > 0.5 ? vec4(casing, 0.6 * around) : vec4(vTint.rgb, core);
    colour.a *= vTint.a;
    if (colour.a < 0.02) discard;
    gl_FragColor = colour;
  }`;

/** Numbers per segment: from, to, colour with opacity, width and dashes. */
const STRIDE = 13;

export class Lines {
  /**
   * @param {number} capacity segments; more are left out
   * @param {{above?: boolean}} look above: whether they hide whatever is there
   */
  constructor(capacity = 4096, { above = false } = {}) {
    this.capacity = capacity;
    this.count = 0;
    this.data = new Float32Array(STRIDE * capacity);
    const geometry = new THREE.InstancedBufferGeometry();
    const corners = new Float32Array([0, -1, 0, 1, -1, 0, 1, 1, 0, 0, 1, 0]);
    geometry.setAttribute("position", new THREE.BufferAttribute(corners, 3));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    this.buffer = new THREE.InstancedInterleavedBuffer(this.data, STRIDE);
    this.buffer.setUsage(THREE.DynamicDrawUsage);
    const part = (size, at) => new THREE.InterleavedBufferAttribute(this.buffer, size, at);
    geometry.setAttribute("from", part(3, 0));
    geometry.setAttribute("to", part(3, 3));
    geometry.setAttribute("tint", part(4, 6));
    geometry.setAttribute("style", part(3, 10));
    geometry.instanceCount = 0;
    this.geometry = geometry;
    this.materials = [material(1, above), material(0, above)];
    this.mesh = new THREE.Group();
    this.materials.forEach((look, i) => {
      const mesh = new THREE.Mesh(geometry, look);
      mesh.frustumCulled = false;
      mesh.renderOrder = (above ? 16 : 3) + i;
      this.mesh.add(mesh);
    });
  }

  clear() {
    this.count = 0;
  }

  /**
   * @param {ArrayLike<number>} a
   * @param {ArrayLike<number>} b
   * @param {THREE.Color} colour
   * @param {{width?: number, opacity?: number, dash?: [number, number]|null}} look dash: where
   *   along its dashes the segment begins and ends, one period is 1
   */
  add(a, b, colour, { width = 2, opacity = 1, dash = null } = {}) {
    if (this.count >= this.capacity) return;
    const at = this.count * STRIDE;
    const { data } = this;
    for (let i = 0; i < 3; i += 1) {
      data[at + i] = a[i];
      data[at + 3 + i] = b[i];
    }
    data[at + 6] = colour.r;
    data[at + 7] = colour.g;
    data[at + 8] = colour.b;
    data[at + 9] = opacity;
    data[at + 10] = width;
    data[at + 11] = dash ? dash[0] : 0;
    data[at + 12] = dash ? dash[1] : 0;
    this.count += 1;
  }

  /** Shows what was added since `clear`. */
  finish() {
    this.geometry.instanceCount = this.count;
    this.mesh.visible = this.count > 0;
    this.buffer.clearUpdateRanges();
    this.buffer.addUpdateRange(0, this.count * STRIDE);
    this.buffer.needsUpdate = true;
  }

  /** @param {string} colour around all of them */
  setCasing(colour) {
    for (const { uniforms } of this.materials) uniforms.casing.value.set(colour);
  }

  /** @param {number} width @param {number} height of the canvas in its own pixels */
  setScreen(width, height, ratio) {
    for (const { uniforms } of this.materials) {
      uniforms.screen.value.set(width, height);
      uniforms.ratio.value = ratio;
    }
  }
}

function material(below, above) {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    transparent: true,
    depthWrite: false,
    depthTest: !above,
    side: THREE.DoubleSide,
    uniforms: {
      screen: { value: new THREE.Vector2(1, 1) },
      ratio: { value: 1 },
      below: { value: below },
      casing: { value: new THREE.Color("#0b0d12") },
    },
  });
}
