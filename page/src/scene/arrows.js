/**
 * Arrows that push onto the skin: their length tells the force, their width is the same in pixels
 * from everywhere. What was found is filled; what is known to be there is a hollow shape around it,
 * so that the filled one fits where both agree.
 */

import * as THREE from "three";

/** Of the skin's size: the shortest and the longest arrow. */
const SHORT = 0.07;
const LONG = 0.3;
/** Force in N whose arrow is half way between. */
const HALF = 2;

/**
 * @param {number} force in N
 * @param {number} size of the skin, m
 * @returns {number} length of its arrow, m; grows with force, without end but below a bound
 */
export function arrowLength(force, size) {
  const f = Math.max(0, force);
  return size * (SHORT + ((LONG - SHORT) * f) / (f + HALF));
}

const VERTEX = /* glsl */ `
  attribute vec3 tail;
  attribute vec3 tip;
  attribute vec4 tint;    // w: 1 hollow
  uniform vec2 screen;    // px
  uniform float ratio;
  varying vec2 vAt;
  varying float vReach;
  varying vec4 vTint;
  void main() {
    vec4 a = projectionMatrix * modelViewMatrix * vec4(tail, 1.0);
    vec4 b = projectionMatrix * modelViewMatrix * vec4(tip, 1.0);
    vec2 along = (b.xy / b.w - a.xy / a.w) * screen * 0.5;
    vReach = length(along);
    along = vReach > 1e-3 ? along / vReach : vec2(0.0, -1.0);
    vec2 across = vec2(-along.y, along.x);
    float room = 16.0 * ratio;
    float end = position.x * 2.0 - 1.0;
    gl_Position = mix(a, b, position.x);
    vec2 off = along * end * room + across * position.y * room;
    vAt = vec2(position.x * vReach + end * room, position.y * room);
    gl_Position.xy += off / screen * 2.0 * gl_Position.w;
    gl_Position.z -= 5e-3 * gl_Position.w;  // its head is seen on a curved skin, too
    vTint = tint;
  }`;

const FRAGMENT = /* glsl */ `
  uniform vec3 casing;
  uniform float ratio;
  varying vec2 vAt;
  varying float vReach;
  varying vec4 vTint;
  // Distance to an arrow along x from 0 to reach, in px
  float arrow(vec2 p, float reach, float half_, float head, float wide) {
    p.y = abs(p.y);
    float edge = ((p.x - reach) * wide + p.y * head) / length(vec2(wide, head));
    float triangle = max(edge, reach - head - p.x);
    float end = max(reach - head + 1.0, 0.0);
    float shaft = length(vec2(p.x - clamp(p.x, 0.0, end), p.y)) - half_;
    return min(triangle, shaft);
  }
  void main() {
    float head = min(15.0 * ratio, max(vReach, 6.0 * ratio));
    float hollow = vTint.w;
    float wider = hollow * 4.2 * ratio;
    // What is wider all around still ends where it points to: 0.418 is the sine of half its angle
    float reach = vReach - wider / 0.418;
    float d = arrow(vAt, reach, 2.1 * ratio, head, 0.46 * head) - wider;
    float inside = 1.0 - smoothstep(-0.6, 0.6, d);
    float around = 1.0 - smoothstep(0.5 * ratio, 1.9 * ratio, d);
    float border = inside * smoothstep(-1.7 * ratio - 0.6, -1.7 * ratio + 0.6, d);
    vec3 colour = mix(casing, vTint.rgb, mix(inside, max(border, 0.8 * inside), hollow));
    float shell = max(border, max(0.28 * inside, 0.6 * around * (1.0 - inside)));
    float alpha = mix(max(inside, 0.75 * around), shell, hollow);
    if (alpha < 0.02) discard;
    gl_FragColor = vec4(colour, alpha);
  }`;

/** Numbers per arrow: tail, tip, colour, whether hollow. */
const STRIDE = 10;

/** All arrows in one buffer, written anew at every picture. */
export class Arrows {
  /** @param {number} capacity arrows; more are left out */
  constructor(capacity = 256) {
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
    geometry.setAttribute("tail", part(3, 0));
    geometry.setAttribute("tip", part(3, 3));
    geometry.setAttribute("tint", part(4, 6));
    geometry.instanceCount = 0;
    this.geometry = geometry;
    this.material = material();
    this.mesh = new THREE.Mesh(geometry, this.material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 6;
  }

  clear() {
    this.count = 0;
  }

  /**
   * @param {ArrayLike<number>} tail
   * @param {ArrayLike<number>} tip on the skin
   * @param {THREE.Color} colour
   * @param {boolean} hollow
   */
  add(tail, tip, colour, hollow = false) {
    if (this.count >= this.capacity) return;
    const at = this.count * STRIDE;
    const { data } = this;
    for (let i = 0; i < 3; i += 1) {
      data[at + i] = tail[i];
      data[at + 3 + i] = tip[i];
    }
    data[at + 6] = colour.r;
    data[at + 7] = colour.g;
    data[at + 8] = colour.b;
    data[at + 9] = hollow ? 1 : 0;
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

  setScreen(width, height, ratio) {
    this.material.uniforms.screen.value.set(width, height);
    this.material.uniforms.ratio.value = ratio;
  }

  setCasing(colour) {
    this.material.uniforms.casing.value.set(colour);
  }
}

function material() {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    transparent: true,
    depthWrite: false,
    side: THREE.DoubleSide,
    uniforms: {
      screen: { value: new THREE.Vector2(1, 1) },
      ratio: { value: 1 },
      casing: { value: new THREE.Color() },
    },
  });
}
