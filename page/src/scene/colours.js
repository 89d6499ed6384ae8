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

const tables = new Map();

/** @returns {string[]} names of the maps */
export function mapNames() {
  return Object.keys(TABLES);
}

/**
 * Colours of a map from low to high.
 *
 * @param {string} name
 * @returns {Uint8Array} 256 times red, green, blue, alpha (sRGB, 0..255)
 */
export function mapTable(name) {
  if (!(name in TABLES)) throw new RangeError(`colour map ${name}: one of ${mapNames()}`);
  if (!tables.has(name)) tables.set(name, decode(TABLES[name]));
  return tables.get(name);
}

/**
 * Colour of one value.
 *
 * @param {string} name of the map
 * @param {number} value 0 (low) .. 1 (high); beyond, the end's colour
 * @returns {[number, number, number]} sRGB, 0..255
 */
export function mapColour(name, value) {
  const table = mapTable(name);
  const at = 4 * Math.min(LEVELS - 1, Math.max(0, Math.round(value * (LEVELS - 1))));
  return [table[at], table[at + 1], table[at + 2]];
}

/**
 * The same map as a CSS gradient, for a colour bar.
 *
 * @param {string} name
 * @param {string} direction such as "to right" or "to top"
 * @returns {string}
 */
export function mapGradient(name, direction = "to right") {
  const stops = [];
  for (let i = 0; i <= 32; i += 1) stops.push(`rgb(${mapColour(name, i / 32).join(" ")})`);
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
