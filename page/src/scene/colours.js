/**
 * Colour maps: from a value to the colour that the surface and the colour bar both show.
 */

import { TABLES } from "./tables.js";

/** Colours in a map. */
export const LEVELS = 256;

/** Which map shows which quantity: one look tells what is on the screen. */
export const MAP_OF = {
  pressure: "viridis",
  taxels: "viridis",
  deformation: "cividis",
  uncertainty: "plasma",
};

/** Part of a map that leads from the colour of bare skin to the map's own, on dark and bright skin. */
const FADE = { dark: 0.12, bright: 0.22 };

/**
 * @typedef {object} Ground
 * @property {string} plain "#rrggbb" of skin that nothing presses: what a map begins with
 * @property {boolean} bright whether maps go from bright to dark, as on bright skin
 */

const tables = new Map();

/** @returns {string[]} names of the maps */
export function mapNames() {
  return Object.keys(TABLES);
}

/**
 * Colours of a map from low to high.
 *
 * @param {string} name
 * @param {Ground|null} [ground] of the skin; null: the map alone
 * @returns {Uint8Array} 256 times red, green, blue, alpha (sRGB, 0..255)
 */
export function mapTable(name, ground = null) {
  if (!(name in TABLES)) throw new RangeError(`colour map ${name}: one of ${mapNames()}`);
  const key = ground ? `${name} ${ground.plain} ${ground.bright}` : name;
  if (!tables.has(key)) {
    tables.set(key, ground ? grounded(mapTable(name), ground) : decode(TABLES[name]));
  }
  return tables.get(key);
}

/** The map as it is shown on skin: at zero it is the skin's own colour. */
function grounded(map, { plain, bright }) {
  const table = new Uint8Array(map.length).fill(255);
  const skin = [1, 3, 5].map((at) => Number.parseInt(plain.slice(at, at + 2), 16));
  for (let i = 0; i < LEVELS; i += 1) {
    const t = Math.min(1, i / ((bright ? FADE.bright : FADE.dark) * (LEVELS - 1)));
    const share = t * t * (3 - 2 * t);
    const from = 4 * (bright ? LEVELS - 1 - i : i);
    for (let c = 0; c < 3; c += 1) {
      table[4 * i + c] = Math.round(skin[c] + share * (map[from + c] - skin[c]));
    }
  }
  return table;
}

/**
 * Colour of one value.
 *
 * @param {string} name of the map
 * @param {number} value 0 (low) .. 1 (high); beyond, the end's colour
 * @param {Ground|null} [ground]
 * @returns {[number, number, number]} sRGB, 0..255
 */
export function mapColour(name, value, ground = null) {
  const table = mapTable(name, ground);
  const at = 4 * Math.min(LEVELS - 1, Math.max(0, Math.round(value * (LEVELS - 1))));
  return [table[at], table[at + 1], table[at + 2]];
}

/**
 * The same map as a CSS gradient, for a colour bar.
 *
 * @param {string} name
 * @param {string} direction such as "to right" or "to top"
 * @param {Ground|null} [ground]
 * @returns {string}
 */
export function mapGradient(name, direction = "to right", ground = null) {
  const stops = [];
  for (let i = 0; i <= 64; i += 1) stops.push(`rgb(${mapColour(name, i / 64, ground).join(" ")})`);
  return `linear-gradient(${direction}, ${stops.join(", ")})`;
}

function decode(text) {
  const table = new Uint8Array(4 * LEVELS);
  for (let i = 0; i < LEVELS; i += 1) {
    for (let c = 0; c < 3; c += 1) {
      table[4 * i + c] = Number.parseInt(text.slice(6 * i + 2 * c, 6 * i + 2 * c + 2), 16);
    }
    table[4 * i + 3] = 255;
  }
  return table;
}
