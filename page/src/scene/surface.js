/**
 * The skin of one patch on one grid: a mesh that sinks where it is pressed, coloured by a map.
 *
 * Colours are those of the colour bar: the map's table is looked up per pixel and written as it is.
 * A light that stays with the camera shades only what leans away from the skin at rest; flat skin
 * and the bottom of a dent are exact.
 */

import * as THREE from "three";
import { Refiner, coverage, refinement, triangles } from "./grid.js";
import { Nodes } from "./nodes.js";
import { steepestSeen } from "./ruler.js";

/** Dents are shallow: they are lit as if they were so many times deeper than they are drawn. */
const RELIEF = 3;
/** Slope that steeper walls are lit as: none of them is black. */
const STEEPEST = 0.9;

const VERTEX = /* glsl */ `
  attribute vec3 outward;
  attribute vec3 along;    // the plane's first axis
  attribute float cover;
  attribute float height;
  attribute float colour;
  attribute vec2 slope;
  attribute vec2 place;
  uniform float depth;
  uniform vec3 mean;       // outer side of the patch as a whole; short where it closes around
  varying float vCover;
  varying float vColour;
  varying vec2 vPlace;
  varying float vFacing;
  varying vec2 vLit;       // by the light, and by its gloss, beyond what the skin at rest gets
  const vec3 KEY = vec3(-0.75, 0.36, 0.555);  // of the camera: from its left, above and behind it
  float gloss(vec3 normal, vec3 eye) {
    return pow(max(dot(normal, normalize(KEY + eye)), 0.0), 28.0);
  }
  void main() {
    vec3 sunk = position - outward * (height * depth);
    vec4 seen = modelViewMatrix * vec4(sunk, 1.0);
    vec3 across = cross(outward, along);
    vec3 lean = (along * slope.x + across * slope.y) * depth * ${RELIEF.toFixed(1)};
    lean /= sqrt(1.0 + dot(lean, lean) / ${(STEEPEST * STEEPEST).toFixed(2)});
    vCover = cover;
    vColour = colour;
    vPlace = place;
    vec3 eye = normalize(-seen.xyz);
    vec3 rest = normalize(normalMatrix * outward);
    vec3 normal = normalize(normalMatrix * (outward + lean));
    vFacing = dot(rest, eye);
    vLit = vec2(dot(normal - rest, KEY), max(gloss(normal, eye) - gloss(rest, eye), 0.0));
    vLit.x += 0.3 * dot(rest - normalMatrix * mean, KEY);  // nothing where the skin is flat
    gl_Position = projectionMatrix * seen;
  }`;

const FRAGMENT = /* glsl */ `
  uniform sampler2D map;
  uniform vec2 span;      // what colour 0 and 1 stand for
  uniform vec2 bar;       // ends of the colour bar
  uniform vec3 grey;
  uniform vec3 rim;
  uniform vec3 ink;       // of the ruled squares
  uniform float plain;    // 1: no colours of the map
  uniform float missing;  // 1: no reading
  varying float vCover;
  varying float vColour;
  varying vec2 vPlace;
  varying float vFacing;
  varying vec2 vLit;
  void main() {
    float soft = fwidth(vCover) + 1e-5;
    float inside = clamp((vCover - 0.5) / soft + 0.5, 0.0, 1.0);
    if (inside <= 0.0) discard;
    float edge = 1.0 - clamp((vCover - 0.5) / (2.2 * soft), 0.0, 1.0);
    vec2 wide = fwidth(vPlace) + 1e-6;  // of a pixel, in squares
    vec2 cell = abs(fract(vPlace) - 0.5) / wide;
    float line = 1.0 - min(min(cell.x, cell.y), 1.0);
    line *= 1.0 - smoothstep(0.10, 0.22, max(wide.x, wide.y));
    if (vFacing < 0.0) {
      // Seen from inside: outlines only, which hide nothing behind them
      float seen = max(edge * inside, 0.2 * line);
      if (seen < 0.03) discard;
      gl_FragColor = vec4(rim, 0.6 * seen);
      return;
    }
    float value = span.x + vColour * (span.y - span.x);
    float at = clamp((value - bar.x) / max(bar.y - bar.x, 1e-30), 0.0, 1.0);
    vec3 colour = texture2D(map, vec2((at * 255.0 + 0.5) / 256.0, 0.5)).rgb;
    colour = mix(colour, grey, max(plain, missing));
    colour = mix(colour, ink, 0.09 * line * (1.0 - missing));
    colour *= 1.0 + 0.55 * min(vLit.x, 0.0);
    colour += (1.0 - colour) * 0.40 * max(vLit.x, 0.0);
    colour += 0.16 * vLit.y;
    if (missing > 0.5) {
      float stripe = abs(fract((vPlace.x + vPlace.y) * 0.7) - 0.5);
      colour = mix(colour, rim, 0.35 * smoothstep(0.20, 0.25, stripe));
    }
    colour = mix(colour, rim, edge);
    colour *= 0.84 + 0.16 * smoothstep(0.0, 0.42, vFacing);  // rounds off a limb's sides
    gl_FragColor = vec4(colour, inside);
  }`;

export class Surface {
  /**
   * @param {object} head of the geometry
   * @param {object} arrays of the geometry
   * @param {{table: THREE.Texture, patches: number, finest: number,
   *   border: import("./border.js").Border|null, ruling: number}} look colours of the map, how many
   *   patches share the picture, vertices along a side, where the skin ends, side of the ruled squares
   */
  constructor(head, arrays, { table, patches, finest, border, ruling }) {
    this.pad = border?.pad(arrays.plane) ?? 1;
    this.nodes = new Nodes(head, arrays, this.pad);
    this.border = border;
    this.ruling = ruling;
    const { rows, columns } = this.nodes;
    const factor = refinement(head.rows, head.columns, patches, finest);
    this.refiner = new Refiner(rows, columns, factor);
    this.geometry = this.#geometry();
    this.material = material(table);
    this.mean = meanNormal(this.nodes);
    this.material.uniforms.mean.value.copy(this.mean);
    this.mesh = new THREE.Mesh(this.geometry, this.material);
    this.mesh.frustumCulled = false; // its sphere would not know how deep the dents are drawn
    this.leans = new Float32Array(2 * this.nodes.count);
    this.heightScale = 0;
    this.exaggeration = 1;
    this.steepness = 0; // of the steepest wall, per unit of height
    this.steepest = Infinity; // slope that is drawn
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
    const plane = spread(nodes.plane, 2);
    this.border?.trim(cover, plane.array, 4 * nodes.pitch);
    const geometry = new THREE.BufferGeometry();
    const index = triangles(refiner.fineRows, refiner.fineColumns, cover);
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    const positions = spread(nodes.positions, 3);
    geometry.setAttribute("position", positions);
    geometry.setAttribute("outward", spread(nodes.normals, 3));
    geometry.setAttribute("along", firstAxis(positions.array, refiner));
    const place = plane.array.map((value) => value / this.ruling);
    geometry.setAttribute("place", new THREE.BufferAttribute(place, 2));
    geometry.setAttribute("cover", new THREE.BufferAttribute(cover, 1));
    geometry.setAttribute("height", moving(new Float32Array(refiner.count), false));
    geometry.setAttribute("colour", moving(new Uint16Array(refiner.count), true));
    geometry.setAttribute("slope", moving(new Float32Array(2 * refiner.count), false, 2));
    return geometry;
  }

  /**
   * @param {Uint16Array|null} height per node; null: flat
   * @param {number} scale m per unit of height
   * @param {number} zero height of skin at rest
   */
  setHeight(height, scale, zero = 0) {
    const was = this.nodes.flat;
    this.nodes.setHeight(height, zero);
    this.heightScale = scale || 0;
    this.steepness = height ? slopes(this.nodes, this.leans) : 0;
    this.#depth();
    if (!height && was) return;
    const { height: fine, slope } = this.geometry.attributes;
    if (height) {
      this.refiner.apply(this.nodes.height, null, fine.array);
      for (const offset of [0, 1]) {
        this.refiner.apply(this.leans, null, slope.array, { stride: 2, offset, bounded: false });
      }
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

  /** @param {THREE.Vector3} out direction to the camera: near walls of dents are not to hide their bottom */
  setView(out) {
    this.steepest = steepestSeen(out.dot(this.mean) / (this.mean.length() || 1));
    this.#depth();
  }

  /** How much deeper than real the dents are drawn: as asked, but no steeper than what can be seen into. */
  get times() {
    const slope = this.steepness * this.heightScale;
    return slope > 0 ? Math.min(this.exaggeration, this.steepest / slope) : this.exaggeration;
  }

  /** How deep a unit of height is drawn, in m. */
  get scale() {
    return this.heightScale * this.times;
  }

  #depth() {
    this.material.uniforms.depth.value = this.scale;
  }

  /** @param {THREE.Vector3} camera @returns {boolean} whether it shows it the outer side as a whole */
  faces(camera) {
    const { centre } = this.nodes.sphere;
    return camera.clone().sub(new THREE.Vector3(...centre)).dot(this.mean) >= 0;
  }

  /** Some places of its border, m. */
  get rim() {
    this.edge ??= rimOf(this.geometry.attributes);
    return this.edge;
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}

function meanNormal({ normals, covered }) {
  const sum = new THREE.Vector3();
  let count = 0;
  for (let k = 0; k < covered.length; k += 1) {
    if (!covered[k]) continue;
    sum.x += normals[3 * k];
    sum.y += normals[3 * k + 1];
    sum.z += normals[3 * k + 2];
    count += 1;
  }
  return sum.divideScalar(Math.max(1, count));
}

/** The outermost drawn vertices in 24 directions of the plane. */
function rimOf({ position, cover, place }) {
  const found = new Map();
  for (let turn = 0; turn < 24; turn += 1) {
    const [c, s] = [Math.cos((turn * Math.PI) / 12), Math.sin((turn * Math.PI) / 12)];
    let [best, most] = [0, -Infinity];
    for (let k = 0; k < cover.count; k += 1) {
      const far = c * place.array[2 * k] + s * place.array[2 * k + 1];
      if (cover.array[k] >= 0.5 && far > most) [best, most] = [k, far];
    }
    found.set(best, Array.from(position.array.subarray(3 * best, 3 * best + 3)));
  }
  return [...found.values()];
}

function moving(array, normalised, size = 1) {
  const attribute = new THREE.BufferAttribute(array, size, normalised);
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
      mean: { value: new THREE.Vector3() },
      plain: { value: 0 },
      missing: { value: 0 },
      ink: { value: new THREE.Color() },
    },
  });
}

/** At each vertex the direction of the plane's first axis, of length 1. */
function firstAxis(positions, { fineRows, fineColumns }) {
  const out = new Float32Array(positions.length);
  for (let k = 0; k < fineRows * fineColumns; k += 1) {
    const c = k % fineColumns;
    const before = 3 * (c > 0 ? k - 1 : k);
    const after = 3 * (c + 1 < fineColumns ? k + 1 : k);
    const d = [0, 1, 2].map((a) => positions[after + a] - positions[before + a]);
    const long = Math.hypot(...d) || 1;
    for (let a = 0; a < 3; a += 1) out[3 * k + a] = d[a] / long;
  }
  return new THREE.BufferAttribute(out, 3);
}

/**
 * How fast the height grows along the plane's axes at each node, x and y, per metre.
 *
 * @returns {number} how fast at most, whatever the direction
 */
function slopes({ height, rows, columns, pitch }, out) {
  const per = 1 / (2 * pitch);
  let most = 0;
  for (let r = 0; r < rows; r += 1) {
    const up = Math.min(rows - 1, r + 1) * columns;
    const down = Math.max(0, r - 1) * columns;
    for (let c = 0; c < columns; c += 1) {
      const k = r * columns + c;
      const east = height[r * columns + Math.min(columns - 1, c + 1)];
      const west = height[r * columns + Math.max(0, c - 1)];
      // Heights point inwards, so the skin's normal leans to where they grow
      out[2 * k] = (east - west) * per;
      out[2 * k + 1] = (height[up + c] - height[down + c]) * per;
      most = Math.max(most, out[2 * k] ** 2 + out[2 * k + 1] ** 2);
    }
  }
  return Math.sqrt(most);
}
