// Arguments: what is wrong with them, and what would be right.

export const RAY_FLOATS = 8;

const QUALITIES = ["fast", "medium", "high"];
/** Coordinates beyond it are none to the kernel. */
const MAX_COORDINATE = 2 ** 42;

/** The number of a quality in options. */
export function qualityNumber(options) {
  const { quality = "high" } = options ?? {};
  if (!QUALITIES.includes(quality)) {
    throw new RangeError(`quality is ${JSON.stringify(quality)}, and should be one of ${QUALITIES.join(", ")}`);
  }
  return QUALITIES.indexOf(quality);
}

export function checkMesh(positions, indices) {
  checkType("positions", positions, Float32Array);
  const corners = indices === null ? 9 : 3;
  if (positions.length % corners !== 0) {
    const whole = indices === null ? "9, three vertices for each triangle" : "3, which is a vertex";
    throw new RangeError(`positions has ${positions.length} numbers, which are not a multiple of ${whole}`);
  }
  for (let i = 0; i < positions.length; i++) {
    if (!(Math.abs(positions[i]) <= MAX_COORDINATE)) {
      throw new RangeError(`positions[${i}] is ${positions[i]}, and should be between ±${MAX_COORDINATE}`);
    }
  }
  if (indices === null) {
    return;
  }
  checkType("indices", indices, Uint32Array, Uint16Array);
  if (indices.length % 3 !== 0) {
    throw new RangeError(`indices has ${indices.length} numbers, which are not a multiple of 3`);
  }
  const vertices = positions.length / 3;
  for (let i = 0; i < indices.length; i++) {
    if (indices[i] >= vertices) {
      throw new RangeError(`indices[${i}] is ${indices[i]}, and there are ${vertices} vertices`);
    }
  }
}

/** How many numbers each point or curve has. */
export const ROUND_FLOATS = { spheres: 4, discs: 7, linear: 8, cubic: 16 };

/** The number of a kind of points or curves. */
export function checkRound(kind, numbers) {
  const kinds = Object.keys(ROUND_FLOATS);
  if (!kinds.includes(kind)) {
    throw new RangeError(`kind is ${JSON.stringify(kind)}, and should be one of ${kinds.join(", ")}`);
  }
  checkType("numbers", numbers, Float32Array);
  checkNumbers("numbers", numbers, ROUND_FLOATS[kind], "primitive");
  return kinds.indexOf(kind);
}

/** The number of rays. */
export function checkRays(rays) {
  checkType("rays", rays, Float32Array);
  return checkNumbers("rays", rays, RAY_FLOATS, "ray");
}

/** The number of points. */
export function checkPoints(points) {
  checkType("points", points, Float32Array);
  return checkNumbers("points", points, 3, "point");
}

/** How many `each` there are in an array of numbers, `floats` for each. */
function checkNumbers(name, numbers, floats, each) {
  if (numbers.length % floats !== 0) {
    throw new RangeError(`${name} has ${numbers.length} numbers, which are not a multiple of ${floats}`);
  }
  for (let i = 0; i < numbers.length; i++) {
    if (Number.isNaN(numbers[i])) {
      throw new RangeError(`${name}[${i}], of ${each} ${Math.floor(i / floats)}, is NaN`);
    }
  }
  return numbers.length / floats;
}

export function checkRadius(radius) {
  if (typeof radius !== "number" || !(radius >= 0)) {
    throw new RangeError(`radius is ${String(radius)}, and should be 0 or more; it may be Infinity`);
  }
}

export function checkMask(mask) {
  if (typeof mask !== "number" || !(mask >= 0 && mask <= 0xffffffff && Number.isInteger(mask))) {
    throw new RangeError(`mask is ${String(mask)}, and should be a whole number of 32 bits`);
  }
  return mask;
}

export function checkTime(time) {
  if (typeof time !== "number" || Number.isNaN(time)) {
    throw new RangeError(`time is ${String(time)}, and should be a number from 0 to 1`);
  }
}

/** The time of each ray; null if all are at 0. */
export function checkTimes(time, count) {
  if (typeof time === "number") {
    checkTime(time);
    return time === 0 ? null : new Float32Array(count).fill(time);
  }
  if (!isTyped(time, Float32Array)) {
    throw new TypeError(`time is ${typeName(time)}, and should be a number from 0 to 1 or a Float32Array of them`);
  }
  checkLength("time", time, count, "rays");
  checkNumbers("time", time, 1, "ray");
  return time;
}

export function checkFilter(filter) {
  if (filter !== undefined && typeof filter !== "function") {
    throw new TypeError(`filter is ${typeName(filter)}, and should be a function`);
  }
}

export function checkTransforms(matrices) {
  if (!Array.isArray(matrices) || matrices.length === 0) {
    throw new TypeError("transforms should be an array of one matrix or more");
  }
  return matrices;
}

export function checkMatrix(matrix) {
  if (matrix === null || typeof matrix !== "object" || matrix.length !== 16) {
    throw new TypeError(`transform is ${typeName(matrix)}, and should be 16 numbers, column by column`);
  }
  for (let i = 0; i < 16; i++) {
    if (!Number.isFinite(Math.fround(matrix[i]))) {
      throw new RangeError(`transform[${i}] is ${String(matrix[i])}, and should be a finite number`);
    }
  }
  if (matrix[3] !== 0 || matrix[7] !== 0 || matrix[11] !== 0 || matrix[15] !== 1) {
    const row = [3, 7, 11, 15].map((i) => matrix[i]).join(", ");
    throw new RangeError(`the last row of transform is ${row}, and should be 0, 0, 0, 1`);
  }
}

export function checkHits(hits, count, inScene) {
  const arrays = [["t", Float32Array], ["u", Float32Array], ["v", Float32Array], ["triangle", Int32Array]];
  if (inScene) {
    arrays.push(["instance", Int32Array]);
  }
  if (hits === null || typeof hits !== "object") {
    const names = arrays.map(([name]) => name);
    const last = names.pop();
    throw new TypeError(`hits is ${typeName(hits)}, and should hold the arrays ${names.join(", ")} and ${last}`);
  }
  for (const [name, type] of arrays) {
    checkType(`hits.${name}`, hits[name], type);
    checkLength(`hits.${name}`, hits[name], count, "rays");
  }
  return hits;
}

export function checkLength(name, array, count, of) {
  if (array.length !== count) {
    throw new RangeError(`${name} has ${array.length} elements for ${count} ${of}`);
  }
}

export function checkType(name, value, ...types) {
  if (!types.some((type) => isTyped(value, type))) {
    throw new TypeError(`${name} is ${typeName(value)}, and should be a ${types.map((type) => type.name).join(" or ")}`);
  }
  if (value.length === 0 && isDetached(value.buffer)) {
    throw new TypeError(`${name} has a buffer that is detached, as it was transferred: it has no numbers any more`);
  }
}

/** Whether it is a typed array of this kind, of any realm: a frame's, or a vm's. */
export function isTyped(value, type) {
  return ArrayBuffer.isView(value) && value[Symbol.toStringTag] === type.name;
}

function isDetached(buffer) {
  try {
    return new Uint8Array(buffer) === null;
  } catch {
    return true;
  }
}

/** What it is, by its own word: `String`, `Float32Array`, `WebAssembly.Module`. */
export function tagOf(value) {
  return Object.prototype.toString.call(value).slice("[object ".length, -1);
}

export function typeName(value) {
  if (value === null || typeof value !== "object") {
    return String(value);
  }
  const name = value.constructor?.name ?? "object";
  return `${/^[AEIO]/.test(name) ? "an" : "a"} ${name}`;
}
