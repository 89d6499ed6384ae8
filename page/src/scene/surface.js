/**
 * The skin of one patch on one grid: a mesh that sinks where it is pressed, coloured by a map.
 *
 * Colours are those of the colour bar: the map's table is looked up per pixel and written as it is.
 * Only where the skin slopes, a mild shade is added; flat skin and the bottom of a dent are exact.
 */

import * as THREE from "three";
import { Refiner, coverage, refinement, triangles } from "./grid.js";
import { Nodes } from "./nodes.js";

const VERTEX = /* glsl */ `
  attribute vec3 outward;
  attribute float cover;
  attribute float height;
  attribute float colour;
  attribute float slope;
  attribute vec2 place;
  uniform float depth;
  uniform float lower;
  varying float vCover;
  varying float vColour;
  varying float vSlope;
  varying vec2 vPlace;
  varying float vFacing;
  void main() {
    vec3 sunk = position - outward * (height * depth + lower);
    vec4 seen = modelViewMatrix * vec4(sunk, 1.0);
    vCover = cover;
    vColour = colour;
    vSlope = slope * depth;
    vPlace = place;
    vFacing = dot(normalize(normalMatrix * outward), normalize(-seen.xyz));
    gl_Position = projectionMatrix * seen;
  }`;

const FRAGMENT = /* glsl */ `
  uniform sampler2D map;
  uniform vec2 span;      // what colour 0 and 1 stand for
  uniform vec2 bar;       // ends of the colour bar
  uniform vec3 grey;
  uniform vec3 rim;
  uniform float plain;    // 1: no colours of the map
  uniform float missing;  // 1: no reading
  uniform float lines;
  varying float vCover;
  varying float vColour;
  varying float vSlope;
  varying vec2 vPlace;
  varying float vFacing;
  void main() {
    float soft = fwidth(vCover) + 1e-5;
    float inside = clamp((vCover - 0.5) / soft + 0.5, 0.0, 1.0);
    if (inside <= 0.0) discard;
    float value = span.x + vColour * (span.y - span.x);
    float at = clamp((value - bar.x) / max(bar.y - bar.x, 1e-30), 0.0, 1.0);
    vec3 colour = texture2D(map, vec2((at * 255.0 + 0.5) / 256.0, 0.5)).rgb;
    colour = mix(colour, grey, max(plain, missing));
    float steep = vSlope / sqrt(1.0 + vSlope * vSlope);
    colour *= 1.0 + 0.22 * min(steep, 0.0);
    colour += (1.0 - colour) * 0.12 * max(steep, 0.0);
    vec2 wide = fwidth(vPlace) + 1e-6;  // of a pixel, in cells
    vec2 cell = abs(fract(vPlace - 0.5) - 0.5) / wide;
    float line = 1.0 - min(min(cell.x, cell.y), 1.0);
    line *= 1.0 - smoothstep(0.10, 0.22, max(wide.x, wide.y));
    colour = mix(colour, vec3(1.0), line * lines * (1.0 - missing));
    if (missing > 0.5) {
      float stripe = abs(fract((vPlace.x + vPlace.y) * 0.25) - 0.5);
      colour = mix(colour, rim, 0.35 * smoothstep(0.20, 0.25, stripe));
    }
    float edge = 1.0 - clamp((vCover - 0.5) / (2.2 * soft), 0.0, 1.0);
    colour = mix(colour, rim, edge);
    colour *= 0.84 + 0.16 * smoothstep(0.0, 0.42, abs(vFacing));  // rounds off a limb's sides
    if (vFacing < 0.0) colour = mix(colour, rim, 0.6) * 0.75;
    gl_FragColor = vec4(colour, inside);
  }`;

/** Where the light comes from, in the patch's plane: the upper left. */
const LIGHT = [-0.7, 0.7];

export class Surface {
  /**
   * @param {object} head of the geometry
   * @param {object} arrays of the geometry
   * @param {{table: THREE.Texture, patches: number, finest: number,
   *   border: import("./border.js").Border|null}} look colours of the map, how many patches share
   *   the picture, vertices along a side, where the skin ends
   */
  constructor(head, arrays, { table, patches, finest, border }) {
    this.pad = border?.pad(arrays.plane) ?? 1;
    this.nodes = new Nodes(head, arrays, this.pad);
    this.border = border;
    const { rows, columns } = this.nodes;
    const factor = refinement(head.rows, head.columns, patches, finest);
    this.refiner = new Refiner(rows, columns, factor);
    this.geometry = this.#geometry();
    this.material = material(table);
    this.mesh = new THREE.Mesh(this.geometry, this.material);
    this.mesh.frustumCulled = false; // its sphere would not know how deep the dents are drawn
    this.heightScale = 0;
    this.exaggeration = 1;
  }

  #geometry() {
    const { nodes, refiner } = this;
    const cover = new Float32Array(refiner.count);
    const reached = coverage(nodes.rows, nodes.columns, nodes.covered, this.pad);
    refiner.apply(reached, null, cover);
    const spread = (values, stride) => {
      const out = new Float32Array(stride * refiner.count);
      for (let offset = 0; offset < stride; offset += 1) {
        refiner.apply(values, null, out, { stride, offset, bounded: false });
      }
      return new THREE.BufferAttribute(out, stride);
    };
    const place = nodes.plane.map((value, i) => (value - nodes.origin[i % 2]) / nodes.pitch);
    const plane = spread(nodes.plane, 2);
    this.border?.trim(cover, plane.array, 4 * nodes.pitch);
    const geometry = new THREE.BufferGeometry();
    const index = triangles(refiner.fineRows, refiner.fineColumns, cover);
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    geometry.setAttribute("position", spread(nodes.positions, 3));
    geometry.setAttribute("outward", spread(nodes.normals, 3));
    geometry.setAttribute("place", spread(place, 2));
    geometry.setAttribute("cover", new THREE.BufferAttribute(cover, 1));
    for (const name of ["height", "colour"]) {
      geometry.setAttribute(name, moving(new Uint16Array(refiner.count), true));
    }
    geometry.setAttribute("slope", moving(new Float32Array(refiner.count), false));
    return geometry;
  }

  /**
   * @param {Uint16Array|null} height per node; null: flat
   * @param {number} scale m per unit of height
   */
  setHeight(height, scale) {
    const was = this.nodes.flat;
    this.nodes.setHeight(height);
    this.heightScale = scale || 0;
    this.#depth();
    if (!height && was) return;
    const { height: fine, slope } = this.geometry.attributes;
    if (height) {
      this.refiner.apply(this.nodes.height, null, fine.array);
      slopes(fine.array, this.refiner, this.nodes.pitch / this.refiner.factor, slope.array);
    } else {
      fine.array.fill(0);
      slope.array.fill(0);
    }
    fine.needsUpdate = true;
    slope.needsUpdate = true;
  }

  /**
   * @param {Uint16Array|null} colour per node; null: all `low`
   * @param {number} low what 0 stands for
   * @param {number} high what 65535 stands for
   */
  setColour(colour, low, high) {
    const fine = this.geometry.attributes.colour;
    this.material.uniforms.span.value.set(low, high);
    if (colour) this.refiner.apply(colour, this.nodes.source, fine.array);
    else fine.array.fill(0);
    fine.needsUpdate = true;
  }

  /** @param {number} times how much deeper than real the dents are drawn */
  setExaggeration(times) {
    this.exaggeration = times;
    this.#depth();
  }

  /** How deep a unit of height is drawn, in m. */
  get scale() {
    return this.heightScale * this.exaggeration;
  }

  #depth() {
    this.material.uniforms.depth.value = 65535 * this.scale;
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}

function moving(array, normalised) {
  const attribute = new THREE.BufferAttribute(array, 1, normalised);
  attribute.setUsage(THREE.DynamicDrawUsage);
  return attribute;
}

function material(table) {
  return new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    side: THREE.DoubleSide,
    transparent: true, // for the soft border only
    depthWrite: true,
    uniforms: {
      map: { value: table },
      span: { value: new THREE.Vector2(0, 0) },
      bar: { value: new THREE.Vector2(0, 1) },
      grey: { value: new THREE.Color() },
      rim: { value: new THREE.Color() },
      depth: { value: 0 },
      lower: { value: 0 },
      plain: { value: 0 },
      missing: { value: 0 },
      lines: { value: 0.08 },
    },
  });
}

/** How much each vertex leans towards the light, per unit of height over the whole range. */
function slopes(height, { fineRows, fineColumns }, step, out) {
  const per = 1 / (2 * step * 65535);
  for (let r = 0; r < fineRows; r += 1) {
    const up = Math.min(fineRows - 1, r + 1) * fineColumns;
    const down = Math.max(0, r - 1) * fineColumns;
    const here = r * fineColumns;
    for (let c = 0; c < fineColumns; c += 1) {
      const east = height[here + Math.min(fineColumns - 1, c + 1)];
      const west = height[here + Math.max(0, c - 1)];
      // Heights point inwards, so the skin's normal leans to where they grow
      const toRight = (east - west) * per;
      const toTop = (height[up + c] - height[down + c]) * per;
      out[here + c] = toRight * LIGHT[0] + toTop * LIGHT[1];
    }
  }
}
