// Trees over triangle meshes, traced in WebAssembly. index.d.ts says what everything is.
//
// Every tree has an instance of its own: what goes wrong in one stays there, and its memory goes away with it.

import { hasSimd } from "./simd.js";

export { hasSimd };
export const RAY_FLOATS = 8;

const QUALITIES = ["fast", "medium", "high"];
/** Coordinates beyond it are none to the kernel. */
const MAX_COORDINATE = 2 ** 42;
/** Rays that are handed over at once: 128 KB, which stay in the processor's cache. */
const BATCH = 4096;

const modules = new Map();

/** The compiled module, which all trees share. */
function compiled(simd) {
  if (!modules.has(simd)) {
    const url = simd ? new URL("halfdome-simd.wasm", import.meta.url) : new URL("halfdome.wasm", import.meta.url);
    const module = fetchBytes(url).then((bytes) => WebAssembly.compile(bytes));
    // What failed for want of a network may work the next time.
    module.catch(() => modules.delete(simd));
    modules.set(simd, module);
  }
  return modules.get(simd);
}

async function fetchBytes(url) {
  if (url.protocol === "file:") {
    const { readFile } = await import("node:fs/promises");
    return readFile(url);
  }
  const response = await fetch(url);
  if (!response.ok) {
    throw new Error(`${url}: ${response.status} ${response.statusText}`);
  }
  return response.arrayBuffer();
}

export async function build(positions, indices = null, options = {}) {
  const { quality = "high", simd = true } = options ?? {};
  checkMesh(positions, indices);
  if (!QUALITIES.includes(quality)) {
    throw new RangeError(`quality is ${JSON.stringify(quality)}, and should be one of ${QUALITIES.join(", ")}`);
  }
  const withSimd = Boolean(simd) && hasSimd();
  const instance = await WebAssembly.instantiate(await compiled(withSimd));
  return new Tree(instance.exports, positions, indices, QUALITIES.indexOf(quality), withSimd);
}

class Tree {
  #exports;
  #rays;
  #triangles;
  #bytes;
  #simd;

  constructor(exports, positions, indices, quality, simd) {
    try {
      write(exports, exports.positions(positions.length), positions);
      if (indices !== null) {
        write(exports, exports.indices(indices.length), indices instanceof Uint32Array ? indices : new Uint32Array(indices));
      }
      this.#triangles = exports.build(quality);
      this.#rays = exports.rays(BATCH);
    } catch (error) {
      // The allocator's last way out.
      throw error instanceof WebAssembly.RuntimeError ? noMemory() : error;
    }
    if (this.#triangles < 0 || this.#rays === 0) {
      throw noMemory();
    }
    this.#bytes = exports.bytes();
    this.#exports = exports;
    this.#simd = simd;
  }

  get triangles() {
    return this.#triangles;
  }

  get bytes() {
    return this.#bytes;
  }

  get simd() {
    return this.#simd;
  }

  closest(rays, hits = undefined) {
    const count = this.#count(rays);
    if (hits === undefined) {
      hits = {
        t: new Float32Array(count),
        u: new Float32Array(count),
        v: new Float32Array(count),
        triangle: new Int32Array(count),
      };
    } else {
      checkHits(hits, count);
    }
    this.#trace(rays, count, (exports, first, batch) => {
      const address = exports.closest(batch);
      const floats = new Float32Array(exports.memory.buffer, address, 3 * batch);
      hits.t.set(floats.subarray(0, batch), first);
      hits.u.set(floats.subarray(batch, 2 * batch), first);
      hits.v.set(floats.subarray(2 * batch), first);
      hits.triangle.set(new Int32Array(exports.memory.buffer, address + 12 * batch, batch), first);
    });
    return hits;
  }

  any(rays, occluded = undefined) {
    const count = this.#count(rays);
    if (occluded === undefined) {
      occluded = new Uint8Array(count);
    } else {
      checkType("occluded", occluded, Uint8Array);
      checkLength("occluded", occluded, count);
    }
    this.#trace(rays, count, (exports, first, batch) => {
      const address = exports.any(batch);
      occluded.set(new Uint8Array(exports.memory.buffer, address, batch), first);
    });
    return occluded;
  }

  free() {
    this.#exports = null;
  }

  /** The number of rays, which are as they should be. */
  #count(rays) {
    if (this.#exports === null) {
      throw new TypeError("this tree was freed");
    }
    checkType("rays", rays, Float32Array);
    if (rays.length % RAY_FLOATS !== 0) {
      throw new RangeError(`rays has ${rays.length} numbers, which are not a multiple of ${RAY_FLOATS}`);
    }
    for (let i = 0; i < rays.length; i++) {
      if (Number.isNaN(rays[i])) {
        throw new RangeError(`rays[${i}], of ray ${Math.floor(i / RAY_FLOATS)}, is NaN`);
      }
    }
    return rays.length / RAY_FLOATS;
  }

  /** Has `answer` take every batch of the rays. */
  #trace(rays, count, answer) {
    const exports = this.#exports;
    for (let first = 0; first < count; first += BATCH) {
      const batch = Math.min(BATCH, count - first);
      write(exports, this.#rays, rays.subarray(RAY_FLOATS * first, RAY_FLOATS * (first + batch)));
      answer(exports, first, batch);
    }
  }
}

/** Writes numbers to an address that the instance gave; 0 stands for no memory. */
function write(exports, address, numbers) {
  if (address === 0) {
    throw noMemory();
  }
  new numbers.constructor(exports.memory.buffer, address >>> 0, numbers.length).set(numbers);
}

function noMemory() {
  return new RangeError("there is no memory left for this mesh: WebAssembly has at most 4 GiB");
}

function checkMesh(positions, indices) {
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

function checkHits(hits, count) {
  if (hits === null || typeof hits !== "object") {
    throw new TypeError(`hits is ${typeName(hits)}, and should hold the arrays t, u, v and triangle`);
  }
  for (const [name, type] of [["t", Float32Array], ["u", Float32Array], ["v", Float32Array], ["triangle", Int32Array]]) {
    checkType(`hits.${name}`, hits[name], type);
    checkLength(`hits.${name}`, hits[name], count);
  }
}

function checkLength(name, array, count) {
  if (array.length !== count) {
    throw new RangeError(`${name} has ${array.length} elements for ${count} rays`);
  }
}

function checkType(name, value, ...types) {
  if (!types.some((type) => value instanceof type)) {
    throw new TypeError(`${name} is ${typeName(value)}, and should be a ${types.map((type) => type.name).join(" or ")}`);
  }
}

function typeName(value) {
  return value === null || typeof value !== "object" ? String(value) : `a ${value.constructor?.name ?? "object"}`;
}
