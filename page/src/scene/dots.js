/**
 * The taxels: one dot each, growing and brightening with its reading; a cross where one is dead, over
 * what it would read.
 */

import * as THREE from "three";
import { DEAD_COLOUR } from "./theme.js";

/** Reading that stands for a dead taxel or one that is left out. */
export const DEAD = 255;
/** The strongest reading. */
export const FULL = 254;

const VERTEX = /* glsl */ `
  attribute vec3 outward;
  attribute float reading;
  attribute float repaired;
  attribute float height;
  uniform float depth;
  uniform float size;      // px at the distance of one metre
  uniform float lift;      // m
  uniform float large;     // 1: the taxels are what is looked at
  uniform float shown;     // 0: only those that are dead
  varying float vReading;
  varying float vRepaired;
  varying float vSize;
  void main() {
    vec3 sunk = position - outward * height * depth;
    vec4 seen = modelViewMatrix * vec4(sunk, 1.0);
    float facing = dot(normalMatrix * outward, -seen.xyz);
    gl_Position = projectionMatrix * seen;
    // A dot faces the camera while the skin leans: lifted, lest half of it sinks in
    vec4 lifted = projectionMatrix * (seen + vec4(0.0, 0.0, lift, 0.0));
    gl_Position.z = lifted.z / lifted.w * gl_Position.w;
    bool hidden = shown < 0.5 && reading * 255.0 < 254.5;
    if (facing <= 0.0 || hidden) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    vReading = reading * 255.0;
    vRepaired = repaired * 255.0;
    float dead = step(254.5, vReading);
    float level = min(vReading / 254.0, 1.0) * (1.0 - dead);
    float share = mix(0.14 + 0.14 * level, 0.62, large);
    vSize = max(4.0, size / -seen.z * mix(share, mix(0.42, 0.62, large), dead));
    gl_PointSize = vSize;
  }`;

const FRAGMENT = /* glsl */ `
  uniform sampler2D map;
  uniform vec3 dead;
  uniform vec3 rim;
  uniform vec3 plain;   // of a taxel that is not what is looked at
  uniform float large;
  uniform float full;   // what the strongest reading stands for
  uniform vec2 bar;     // ends of the colour bar
  varying float vReading;
  varying float vRepaired;
  varying float vSize;
  vec3 colourOf(float reading) {
    float shade = clamp((reading / 254.0 * full - bar.x) / max(bar.y - bar.x, 1e-30), 0.0, 1.0);
    return texture2D(map, vec2((shade * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  }
  void main() {
    vec2 at = gl_PointCoord * 2.0 - 1.0;
    float soft = 2.0 / vSize;
    if (vReading > 254.5) {
      float arm = min(abs(at.x - at.y), abs(at.x + at.y)) * 0.7071;
      float wide = max(0.16, 1.1 * soft);
      float inside = 1.0 - smoothstep(wide, wide + soft, arm);
      float casing = 1.0 - smoothstep(wide + 0.16, wide + 0.16 + soft, arm);
      float within = 1.0 - smoothstep(1.0 - soft, 1.0, length(at));
      gl_FragColor = vec4(mix(vec3(0.05), dead, inside), within * max(inside, 0.55 * casing));
      if (vRepaired < 254.5) gl_FragColor = vec4(mix(colourOf(vRepaired), dead, inside), within);
    } else {
      float r = length(at);
      float inside = 1.0 - smoothstep(1.0 - 1.5 * soft, 1.0, r);
      float level = vReading / 254.0;
      vec3 colour = colourOf(vReading);
      float ring = smoothstep(1.0 - 3.2 * soft, 1.0 - 2.2 * soft, r);
      vec4 wide = vec4(mix(colour, rim, ring), 1.0);
      vec4 small = vec4(plain, mix(0.26, 0.9, level));
      gl_FragColor = mix(small, wide, large);
      gl_FragColor.a *= inside;
    }
    if (gl_FragColor.a < 0.02) discard;
  }`;

export class Dots {
  /**
   * @param {ArrayLike<number>} positions three per taxel
   * @param {ArrayLike<number>} normals
   * @param {number} pitch between neighbours, m
   * @param {THREE.Texture} table colours of the map
   */
  constructor(positions, normals, pitch, table) {
    this.count = positions.length / 3;
    this.positions = Float32Array.from(positions);
    this.pitch = pitch;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(this.positions, 3));
    geometry.setAttribute("outward", new THREE.BufferAttribute(Float32Array.from(normals), 3));
    this.reading = attribute(new Uint8Array(this.count));
    this.repaired = attribute(new Uint8Array(this.count).fill(DEAD));
    this.height = attribute(new Float32Array(this.count), false);
    geometry.setAttribute("reading", this.reading);
    geometry.setAttribute("repaired", this.repaired);
    geometry.setAttribute("height", this.height);
    this.material = material(table);
    this.material.uniforms.lift.value = 0.4 * pitch;
    this.mesh = new THREE.Points(geometry, this.material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 2;
    this.nodes = null;
    this.corners = new Uint32Array(this.count);
  }

  /**
   * @param {Uint8Array} readings 0 .. FULL, or DEAD
   * @param {Uint8Array} [repaired] what the dead ones would read, where that is known
   */
  setReadings(readings, repaired) {
    this.reading.array.set(readings.length === this.count ? readings : []);
    this.reading.needsUpdate = true;
    if (repaired?.length === this.count) this.repaired.array.set(repaired);
    else this.repaired.array.fill(DEAD);
    this.repaired.needsUpdate = true;
  }

  /**
   * Lets the dots sink with the skin below them.
   *
   * @param {import("./surface.js").Surface} surface that is shown
   */
  follow(surface) {
    const { nodes } = surface;
    if (this.nodes !== nodes) this.#bind(nodes);
    this.setDepth(surface.scale);
    for (let i = 0; i < this.count; i += 1) this.height.array[i] = nodes.height[this.corners[i]];
    this.height.needsUpdate = true;
  }

  /** @param {number} scale m inwards per unit of height */
  setDepth(scale) {
    this.material.uniforms.depth.value = scale;
  }

  #bind(nodes) {
    this.nodes = nodes;
    for (let i = 0; i < this.count; i += 1) this.corners[i] = closest(nodes, this.positions, 3 * i);
  }

  /**
   * @param {number} full what the strongest reading stands for
   * @param {[number, number]} bar ends of the colour bar
   */
  setColours(full, bar) {
    this.material.uniforms.full.value = full;
    this.material.uniforms.bar.value.set(...bar);
  }

  /**
   * @param {boolean} all or, if not, only those that are dead: that is never hidden
   * @param {boolean} large whether they are what is looked at
   */
  show(all, large) {
    this.material.uniforms.shown.value = all ? 1 : 0;
    this.material.uniforms.large.value = large ? 1 : 0;
  }

  /** @param {import("./theme.js").Theme} theme */
  setTheme({ rim, dot }) {
    this.material.uniforms.rim.value.set(rim);
    this.material.uniforms.plain.value.set(dot);
  }

  /** @param {number} perMetre px that one metre takes at the distance of one metre */
  setSize(perMetre) {
    this.material.uniforms.size.value = perMetre * this.pitch;
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.material.dispose();
  }
}

function attribute(array, normalised = true) {
  const made = new THREE.BufferAttribute(array, 1, normalised);
  made.setUsage(THREE.DynamicDrawUsage);
  return made;
}

function closest(nodes, positions, at) {
  let best = 0;
  let least = Infinity;
  for (let k = 0; k < nodes.count; k += 1) {
    const dx = nodes.positions[3 * k] - positions[at];
    const dy = nodes.positions[3 * k + 1] - positions[at + 1];
    const dz = nodes.positions[3 * k + 2] - positions[at + 2];
    const square = dx * dx + dy * dy + dz * dz;
    if (square < least) {
      least = square;
      best = k;
    }
  }
  return best;
}

function material(table) {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    transparent: true,
    depthWrite: false,
    uniforms: {
      map: { value: table },
      depth: { value: 0 },
      size: { value: 1 },
      lift: { value: 0 },
      large: { value: 0 },
      full: { value: 1 },
      bar: { value: new THREE.Vector2(0, 1) },
      shown: { value: 1 },
      dead: { value: new THREE.Color(DEAD_COLOUR) },
      plain: { value: new THREE.Color("#ffffff") },
      rim: { value: new THREE.Color() },
    },
  });
}
