// The binary messages of the wire: b"SKF1", u32 bytes of the head, the head in JSON, the arrays.

export const WIRE = 1;
const MAGIC = 0x31464b53; // "SKF1" as a little-endian u32
const TYPES = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array, f32: Float32Array };

/** What is wrong with a message; the page says so and goes on. */
export class WireError extends Error {}

/**
 * Decode one binary message.
 * @param {ArrayBuffer} buffer the whole message
 * @returns {{head: object, arrays: Array<TypedArray>}} arrays by their place in head.arrays, and by
 *   name as `arrays.byName[name]`; views of the buffer, nothing is copied
 * @throws {WireError} on any other bytes
 */
export function decode(buffer) {
  if (!(buffer instanceof ArrayBuffer) || buffer.byteLength < 8) throw new WireError("too short");
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== MAGIC) throw new WireError("does not begin with SKF1");
  const start = 8 + view.getUint32(4, true);
  if (start > buffer.byteLength) throw new WireError("ends within its head");
  if (start % 8) throw new WireError("its arrays do not begin at a multiple of 8");
  const head = parseHead(new Uint8Array(buffer, 8, start - 8));
  const arrays = head.arrays.map((entry) => arrayOf(buffer, start, entry));
  arrays.byName = Object.create(null);
  head.arrays.forEach((entry, i) => (arrays.byName[entry.name] = arrays[i]));
  return { head, arrays };
}

function parseHead(bytes) {
  let head;
  try {
    head = JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch {
    throw new WireError("its head is not JSON");
  }
  if (!isObject(head) || typeof head.kind !== "string") throw new WireError("its head has no kind");
  if (!Array.isArray(head.arrays)) throw new WireError("its head lists no arrays");
  return head;
}

function arrayOf(buffer, start, entry) {
  const Kind = isObject(entry) && Object.hasOwn(TYPES, entry.type) ? TYPES[entry.type] : null;
  if (!Kind || typeof entry.name !== "string") throw new WireError("an array of unknown type");
  const { at, length } = entry;
  if (!isCount(at) || at % 4 || !isCount(length)) throw new WireError("an array at no valid place");
  if (start + at + length * Kind.BYTES_PER_ELEMENT > buffer.byteLength) {
    throw new WireError(`ends within its array ${entry.name}`);
  }
  return new Kind(buffer, start + at, length);
}

/** Check what the page reads of a geometry; returns it. */
export function checkGeometry({ head, arrays }) {
  need(isCount(head.patch) && isCount(head.rung), "a geometry without patch and rung");
  need(isCount(head.rows) && isCount(head.columns), "a geometry without rows and columns");
  const nodes = head.rows * head.columns;
  const lengths = { positions: 3 * nodes, normals: 3 * nodes, plane: 2 * nodes, covered: nodes };
  for (const [name, length] of Object.entries(lengths)) {
    need(arrays.byName[name]?.length === length, `a geometry whose ${name} are not ${length} long`);
  }
  const { taxels, taxel_normals: normals } = arrays.byName;
  need(!taxels || (taxels.length % 3 === 0 && normals?.length === taxels.length), "taxels without normals");
  return { head, arrays };
}

/** Check what the page reads of an update; returns it with its lists present. */
export function checkUpdate({ head, arrays }) {
  need(isCount(head.number), "an update without number");
  for (const list of ["patches", "contacts", "truth"]) {
    head[list] ??= [];
    need(Array.isArray(head[list]) && head[list].every(isObject), `an update whose ${list} are no list`);
  }
  for (const patch of head.patches) checkPatch(patch, arrays);
  for (const place of [...head.contacts, ...head.truth]) {
    need(isCount(place.patch), "a contact without patch");
    need(isVector(place.position) && isVector(place.normal), "a contact without place");
    need(Number.isFinite(place.force), "a contact without force");
    place.shear ??= null;
    need(place.shear === null || isShear(place.shear), "a force along the skin without its numbers");
    place.border ??= null;
    need(place.border === null || isLine(place.border), "a border without places");
  }
  for (const contact of head.contacts) {
    contact.outline ??= [];
    need(Array.isArray(contact.outline) && contact.outline.every(isVector), "an outline without places");
    contact.place_cov ??= [null, null, null];
    need(Array.isArray(contact.place_cov) && contact.place_cov.length === 3, "a covariance without its numbers");
  }
  if (head.shapes != null) checkShapes(head.shapes);
  return { head, arrays };
}

/** Images of contacts, in the bodies' own frames; their pressures as bytes of the highest one. */
function checkShapes(shapes) {
  need(isObject(shapes) && typeof shapes.why === "string", "shapes without a word");
  need(Array.isArray(shapes.images) && shapes.images.every(isObject), "shapes without images");
  for (const image of shapes.images) {
    need(isCount(image.patch) && isCount(image.track), "an image without patch and track");
    need(isCount(image.rows) && isCount(image.columns) && image.cell > 0, "an image without cells");
    need(isVector(image.pose) && areNumbers(image.low, 2), "an image without place");
    need(areNumbers([image.peak, image.force, image.area, image.readings], 4), "an image without numbers");
    need(Array.isArray(image.outline) && image.outline.every(isLine), "an image without outline");
    image.bytes = bytesOf(image.pressure);
    need(image.bytes.length === image.rows * image.columns, "an image whose pressures are not all there");
  }
}

function bytesOf(text) {
  try {
    return Uint8Array.from(atob(text), (each) => each.charCodeAt(0));
  } catch {
    throw new WireError("an image whose pressures are no base64");
  }
}

function checkPatch(patch, arrays) {
  need(isCount(patch.i), "a patch without number");
  const kinds = { height: Uint16Array, colour: Uint16Array, taxels: Uint8Array, repaired: Uint8Array };
  for (const [key, Kind] of Object.entries(kinds)) {
    patch[key] ??= -1;
    need(patch[key] === -1 || arrays[patch[key]] instanceof Kind, `a patch without its ${key}`);
  }
  patch.height_zero ??= 0;
  need(isCount(patch.height_zero), "heights without the one of skin at rest");
}

function isShear({ size, angle, vector }) {
  return [size, angle].every(Number.isFinite) && isVector(vector);
}

function need(holds, what) {
  if (!holds) throw new WireError(what);
}

function isObject(value) {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function isCount(value) {
  return Number.isSafeInteger(value) && value >= 0;
}

function isVector(value) {
  return areNumbers(value, 3);
}

function isLine(value) {
  return Array.isArray(value) && value.every((at) => areNumbers(at, 2));
}

function areNumbers(value, count) {
  return Array.isArray(value) && value.length === count && value.every(Number.isFinite);
}
