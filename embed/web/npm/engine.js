// Instances of the module, and how they are talked to: what goes over, in batches, and what comes back.

import {
  checkFilter,
  checkHits,
  checkLength,
  checkMask,
  checkMatrix,
  checkMesh,
  checkPoints,
  checkRadius,
  checkRays,
  checkRound,
  checkTime,
  checkTimes,
  checkType,
  qualityNumber,
  RAY_FLOATS,
} from "./checks.js";
import { hasSimd } from "./simd.js";

/** Rays that are handed over at once: 128 KB, which stay in the processor's cache. */
const BATCH = 4096;
/** Stands for the scene where a mesh has its number. */
export const SCENE = -1;
export const ALL = 0xffffffff;
/** Hits of a ray that a filter judges at first. */
const FEW = 4;

const modules = new Map();

/** Where the modules are, written out for bundlers: plain and with SIMD, for trees alone and for scenes, which is larger. */
const URLS = {
  tree: [new URL("halfdome.wasm", import.meta.url), new URL("halfdome-simd.wasm", import.meta.url)],
  scene: [new URL("halfdome-scene.wasm", import.meta.url), new URL("halfdome-scene-simd.wasm", import.meta.url)],
};

/** The compiled module, which all trees share, or all scenes. */
function compiled(what, simd) {
  const url = URLS[what][Number(simd)];
  if (!modules.has(url)) {
    const module = fetchBytes(url).then((bytes) => WebAssembly.compile(bytes));
    // What failed for want of a network may work the next time.
    module.catch(() => modules.delete(url));
    modules.set(url, module);
  }
  return modules.get(url);
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

/** An instance of the module, with SIMD if that is wanted and there is any. */
export async function instantiate(what, { simd = true } = {}) {
  const withSimd = Boolean(simd) && hasSimd();
  const instance = await WebAssembly.instantiate(await compiled(what, withSimd));
  return new Engine(what, instance.exports, withSimd);
}

/** An instance, and how it is talked to. `free` ends it. */
export class Engine {
  #exports;
  #rays;
  #points = 0;
  /** What it is to the user: a tree or a scene. */
  #what;
  simd;

  constructor(what, exports, simd) {
    this.#what = what;
    this.#exports = exports;
    this.simd = simd;
    this.#rays = exports.rays(BATCH);
    if (this.#rays === 0) {
      throw noMemory();
    }
  }

  get exports() {
    if (this.#exports === null) {
      throw new TypeError(`this ${this.#what} was freed`);
    }
    return this.#exports;
  }

  free() {
    this.#exports = null;
  }

  /** Has the instance do something for which there may be no memory. */
  attempt(work) {
    const exports = this.exports;
    try {
      return work(exports);
    } catch (error) {
      if (error instanceof WebAssembly.RuntimeError) {
        // The allocator's last way out, after which the instance is of no more use.
        this.free();
        throw noMemory();
      }
      throw error;
    }
  }

  #writeMesh(exports, positions, indices) {
    write(exports, exports.positions(positions.length), positions);
    const wide = indices === null || indices instanceof Uint32Array ? indices : new Uint32Array(indices);
    const address = exports.indices(wide === null ? 0 : wide.length);
    if (wide !== null) {
      write(exports, address, wide);
    }
  }

  addMesh(positions, indices, options) {
    checkMesh(positions, indices);
    const quality = qualityNumber(options);
    return this.attempt((exports) => {
      this.#writeMesh(exports, positions, indices);
      const mesh = exports.add_mesh(quality);
      if (mesh < 0) {
        throw noMemory();
      }
      return mesh;
    });
  }

  refit(mesh, positions, indices) {
    checkMesh(positions, indices);
    const decay = this.attempt((exports) => {
      this.#writeMesh(exports, positions, indices);
      const decay = exports.refit(mesh);
      exports.follow?.(mesh);
      return decay;
    });
    if (decay < 0) {
      throw new RangeError(
        "the triangles are not those of the tree: as many are needed, in the same order, of which the same ones have an area",
      );
    }
    return decay;
  }

  addMovingMesh(keys, indices, options) {
    if (!Array.isArray(keys) || keys.length === 0) {
      throw new TypeError("keys should be an array of one Float32Array of positions or more");
    }
    keys.forEach((positions) => checkMesh(positions, indices));
    const lengths = new Set(keys.map((positions) => positions.length));
    if (lengths.size > 1) {
      throw new RangeError(`the keys have ${[...lengths].join(" and ")} numbers, and should have as many`);
    }
    const quality = qualityNumber(options);
    return this.attempt((exports) => {
      exports.forget_keys();
      for (const positions of keys) {
        this.#writeMesh(exports, positions, indices);
        exports.add_key();
      }
      const mesh = exports.add_moving_mesh(quality);
      if (mesh < 0) {
        throw noMemory();
      }
      return mesh;
    });
  }

  addRound(kind, numbers, options) {
    const number = checkRound(kind, numbers);
    const quality = qualityNumber(options);
    return this.attempt((exports) => {
      write(exports, exports.positions(numbers.length), numbers);
      const mesh = exports.add_round(number, quality);
      if (mesh < 0) {
        throw noMemory();
      }
      return mesh;
    });
  }

  /** Writes matrices for the next call. */
  writeMatrices(matrices) {
    matrices.forEach(checkMatrix);
    const exports = this.exports;
    write(exports, exports.matrices(matrices.length), Float32Array.from(matrices.flatMap((matrix) => [...matrix])));
    return exports;
  }

  closest(target, rays, { hits, ...seen }) {
    const batch = this.#batch(target, rays, seen);
    const { count } = batch;
    hits = hits === undefined ? hitsFor(count, target) : checkHits(hits, count, target === SCENE);
    if (batch.filter !== undefined) {
      return this.#accepted(batch, hits);
    }
    this.#trace(batch, (exports, first, length) => {
      const { mask } = batch;
      const address = target === SCENE ? exports.scene_closest(length, mask) : exports.closest(target, length);
      read(exports, address, length, hits, first);
    });
    return hits;
  }

  any(target, rays, { occluded, ...seen }) {
    const batch = this.#batch(target, rays, seen);
    const { count, mask } = batch;
    if (occluded === undefined) {
      occluded = new Uint8Array(count);
    } else {
      checkType("occluded", occluded, Uint8Array);
      checkLength("occluded", occluded, count, "rays");
    }
    if (batch.filter !== undefined) {
      occluded.set(this.#accepted(batch, hitsFor(count, target)).triangle.map((triangle) => Number(triangle >= 0)));
      return occluded;
    }
    this.#trace(batch, (exports, first, length) => {
      const address = target === SCENE ? exports.scene_any(length, mask) : exports.any(target, length);
      occluded.set(new Uint8Array(exports.memory.buffer, address >>> 0, length), first);
    });
    return occluded;
  }

  allHits(target, rays, { most = Infinity, ...seen }) {
    const batch = this.#batch(target, rays, seen);
    if (!(Number.isInteger(most) && most >= 1) && most !== Infinity) {
      throw new RangeError(`most is ${most}, and should be a whole number from 1 on, or Infinity`);
    }
    return this.#allHits(batch, most);
  }

  closestPoint(target, points, { radius = Infinity, mask = ALL, time = 0 }) {
    // Throws if it was freed.
    void this.exports;
    const count = checkPoints(points);
    checkRadius(radius);
    checkMask(mask);
    checkTime(time);
    const { t: distance, ...rest } = hitsFor(count, target);
    const found = { position: new Float32Array(3 * count), distance, ...rest };
    if (this.#points === 0) {
      this.#points = this.attempt((exports) => exports.points(BATCH));
    }
    for (let first = 0; first < count; first += BATCH) {
      const batch = Math.min(BATCH, count - first);
      const numbers = new Float32Array(4 * batch).fill(radius);
      for (let i = 0; i < batch; i++) {
        numbers.set(points.subarray(3 * (first + i), 3 * (first + i) + 3), 4 * i);
      }
      this.attempt((exports) => {
        write(exports, this.#points, numbers);
        const address =
          (target === SCENE ? exports.scene_closest_points(batch, mask, time) : exports.closest_points(target, batch)) >>> 0;
        const columns = read(exports, address, batch, { ...found, t: distance }, first);
        found.position.set(new Float32Array(exports.memory.buffer, address + 4 * columns * batch, 3 * batch), 3 * first);
      });
    }
    return found;
  }

  /** Rays, and what they see. */
  #batch(target, rays, { mask = ALL, time = 0, filter }) {
    // Throws if it was freed.
    void this.exports;
    const count = checkRays(rays);
    checkMask(mask);
    checkFilter(filter);
    return { target, rays, count, mask, times: checkTimes(time, count), filter };
  }

  /** Has `answer` take every part of the batch. */
  #trace({ target, rays, count, times }, answer) {
    for (let first = 0; first < count; first += BATCH) {
      const length = Math.min(BATCH, count - first);
      this.attempt((exports) => {
        write(exports, this.#rays, rays.subarray(RAY_FLOATS * first, RAY_FLOATS * (first + length)));
        if (times !== null) {
          write(exports, exports.times(length), times.subarray(first, first + length));
        } else if (target === SCENE) {
          exports.times(0);
        }
        answer(exports, first, length);
      });
    }
  }

  #allHits(batch, most) {
    const { target, count, mask } = batch;
    const starts = new Uint32Array(count + 1);
    const parts = [];
    this.#trace(batch, (exports, first, length) => {
      const limit = Math.min(most, ALL);
      const address =
        (target === SCENE ? exports.scene_all_hits(length, limit, mask) : exports.all_hits(target, length, limit)) >>> 0;
      const ends = new Uint32Array(exports.memory.buffer, address, length);
      const [before, found] = [starts[first], ends[length - 1]];
      ends.forEach((end, i) => (starts[first + i + 1] = before + end));
      const part = hitsFor(found, target);
      read(exports, address + 4 * length, found, part, 0);
      parts.push(part);
    });
    const hits = hitsFor(starts[count], target);
    for (const name of Object.keys(hits)) {
      let at = 0;
      for (const part of parts) {
        hits[name].set(part[name], at);
        at += part[name].length;
      }
    }
    return { starts, ...hits };
  }

  /** The nearest hits that the filter accepts. It judges the nearest few of each ray, then more of those that have none yet. */
  #accepted(batch, hits) {
    const { target, count, filter } = batch;
    const names = Object.keys(hitsFor(0, target));
    const none = { t: Infinity, u: 0, v: 0, triangle: -1, instance: -1 };
    names.forEach((name) => hits[name].fill(none[name]));
    let pending = Array.from({ length: count }, (_, ray) => ray);
    for (let [judged, most] = [0, FEW]; pending.length > 0; [judged, most] = [most, 4 * most]) {
      const rays = pick(batch.rays, pending, RAY_FLOATS);
      const times = batch.times === null ? null : pick(batch.times, pending, 1);
      const found = this.#allHits({ ...batch, rays, times, count: pending.length }, most);
      pending = pending.filter((ray, i) => {
        const [first, end] = [found.starts[i], found.starts[i + 1]];
        for (let at = first + judged; at < end; at++) {
          const hit = { ray };
          names.forEach((name) => (hit[name] = found[name][at]));
          if (filter(hit)) {
            names.forEach((name) => (hits[name][ray] = found[name][at]));
            return false;
          }
        }
        return end - first === most;
      });
    }
    return hits;
  }
}

/** The elements of these numbers, of so many floats each. */
function pick(array, numbers, floats) {
  const picked = new Float32Array(floats * numbers.length);
  numbers.forEach((number, i) => picked.set(array.subarray(floats * number, floats * (number + 1)), floats * i));
  return picked;
}

/** Arrays for the hits of so many rays. */
function hitsFor(count, target) {
  const hits = {
    t: new Float32Array(count),
    u: new Float32Array(count),
    v: new Float32Array(count),
    triangle: new Int32Array(count),
  };
  return target === SCENE ? { ...hits, instance: new Int32Array(count) } : hits;
}

/** Reads the columns at an address into the arrays, from the element `first` on; how many columns there are. */
function read(exports, address, count, hits, first) {
  const columns = ["t", "u", "v", "triangle", "instance"].filter((name) => hits[name] !== undefined);
  columns.forEach((name, column) => {
    const type = hits[name].constructor;
    hits[name].set(new type(exports.memory.buffer, (address >>> 0) + 4 * count * column, count), first);
  });
  return columns.length;
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

export function nearlyFlat() {
  return new RangeError("the transform is nearly flat: it should have an inverse, or scale by exactly 0, which hides");
}
