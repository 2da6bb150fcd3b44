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
  isTyped,
  qualityNumber,
  RAY_FLOATS,
  ROUND_FLOATS,
} from "./checks.js";
import { load } from "./load.js";

/** Rays that are handed over at once: 128 KB, which stay in the processor's cache. */
const BATCH = 4096;
/** Stands for the scene where a mesh has its number. */
export const SCENE = -1;
export const ALL = 0xffffffff;
/** Hits of a ray that a filter judges at first. */
const FEW = 4;

/** Memory that a build takes, in bytes for each triangle, point or curve at a key: some 120 to 230. With less it is not tried. */
const BUILD_BYTES = 256;
/** And for however few. */
const LEAST_PIECES = 4;
/** What has_room counts. */
const PIECE = 65536;

/** An instance of the module. */
export async function instantiate(what, options) {
  return new Engine(what, await load(what, options));
}

/** An instance, and how it is talked to. `free` ends it. */
export class Engine {
  #exports;
  #rays;
  #points = 0;
  /** What it is to the user: a tree or a scene. */
  #what;
  /** Why there are no exports any more. */
  #end = "was freed";
  simd;

  constructor(what, exports) {
    this.#what = what;
    this.#exports = exports;
    this.simd = exports.simd() === 1;
    this.#rays = exports.rays(BATCH);
    if (this.#rays === 0) {
      throw noMemory();
    }
  }

  get exports() {
    if (this.#exports === null) {
      throw new TypeError(`this ${this.#what} ${this.#end}`);
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
        this.#end = "ran out of memory and is lost";
        throw new RangeError(`there is no memory left, and this ${this.#what} is lost: WebAssembly has at most 4 GiB`);
      }
      throw error;
    }
  }

  #writeMesh(exports, positions, indices) {
    write(exports, exports.positions(positions.length), positions);
    if (indices !== null) {
      write(exports, exports.indices(indices.length), isTyped(indices, Uint32Array) ? indices : new Uint32Array(indices));
    }
  }

  /** Throws if there is no memory for so many bytes: where it ends on the way, the instance is lost. */
  #needRoom(exports, bytes) {
    if (exports.has_room(LEAST_PIECES + Math.ceil(bytes / PIECE)) === 0) {
      throw noMemory();
    }
  }

  addMesh(positions, indices, options) {
    checkMesh(positions, indices);
    const quality = qualityNumber(options);
    return this.attempt((exports) => {
      this.#needRoom(exports, BUILD_BYTES * triangleCount(positions, indices));
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
      // A scene that has the tree keeps it until its next commit.
      this.#needRoom(exports, 2 * (exports.bytes(mesh) >>> 0));
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
      this.#needRoom(exports, BUILD_BYTES * keys.length * triangleCount(keys[0], indices));
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
      this.#needRoom(exports, (BUILD_BYTES * numbers.length) / ROUND_FLOATS[kind]);
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
    const numbers = new Float32Array(16 * matrices.length);
    matrices.forEach((matrix, key) => {
      for (let i = 0; i < 16; i++) {
        numbers[16 * key + i] = matrix[i];
      }
    });
    write(exports, exports.matrices(matrices.length), numbers);
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
    const type = isTyped(hits[name], Int32Array) ? Int32Array : Float32Array;
    hits[name].set(new type(exports.memory.buffer, (address >>> 0) + 4 * count * column, count), first);
  });
  return columns.length;
}

/** Writes numbers to an address that the instance gave; 0 stands for no memory. */
function write(exports, address, numbers) {
  if (address === 0) {
    throw noMemory();
  }
  const type = isTyped(numbers, Uint32Array) ? Uint32Array : Float32Array;
  new type(exports.memory.buffer, address >>> 0, numbers.length).set(numbers);
}

function triangleCount(positions, indices) {
  return indices === null ? positions.length / 9 : indices.length / 3;
}

function noMemory() {
  return new RangeError("there is no memory left for this mesh: WebAssembly has at most 4 GiB");
}

/** What is wrong with one of `count` matrices, by the number that the instance gives. */
export function refusedTransform(code, count) {
  const [key, between] = [Math.floor((-code - 2) / 2), code % 2 !== 0];
  if (between) {
    return new RangeError(
      `halfway from transform ${key} to ${key + 1} it is nearly flat: keys of a rotation should be less than half a turn apart`,
    );
  }
  const [which, hides] = count === 1 ? ["the transform", ", or scale by exactly 0, which hides"] : [`transform ${key}`, ""];
  return new RangeError(`${which} is nearly flat: it should have an inverse${hides}`);
}
