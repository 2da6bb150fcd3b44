// Trees over triangle meshes and scenes of them, traced in WebAssembly. index.d.ts says what everything is.
//
// Every tree and every scene has an instance of its own: what goes wrong in one stays there, and its memory goes away with it.

import {
  checkHits,
  checkMatrix,
  checkMesh,
  checkMask,
  checkPoints,
  checkRays,
  checkRadius,
  checkType,
  checkLength,
  qualityNumber,
  RAY_FLOATS,
} from "./checks.js";
import { hasSimd } from "./simd.js";

export { hasSimd, RAY_FLOATS };

/** Rays that are handed over at once: 128 KB, which stay in the processor's cache. */
const BATCH = 4096;
/** Stands for the scene where a mesh has its number. */
const SCENE = -1;
const ALL = 0xffffffff;

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
async function instantiate(what, { simd = true } = {}) {
  const withSimd = Boolean(simd) && hasSimd();
  const instance = await WebAssembly.instantiate(await compiled(what, withSimd));
  return new Engine(what, instance.exports, withSimd);
}

export async function build(positions, indices = null, options = {}) {
  checkMesh(positions, indices);
  qualityNumber(options);
  const engine = await instantiate("tree", options ?? {});
  engine.addMesh(positions, indices, options);
  return new Tree(engine);
}

export async function createScene(options = {}) {
  return new Scene(await instantiate("scene", options ?? {}));
}

/** An instance, and how it is talked to. `free` ends it. */
class Engine {
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

  /** Writes a matrix for the next call. */
  writeMatrix(matrix) {
    checkMatrix(matrix);
    const exports = this.exports;
    write(exports, exports.matrix(), Float32Array.from(matrix));
    return exports;
  }

  closest(target, rays, hits, mask) {
    // Throws if it was freed.
    void this.exports;
    const count = checkRays(rays);
    hits = hits === undefined ? hitsFor(count, target) : checkHits(hits, count, target === SCENE);
    this.#trace(rays, count, (exports, first, batch) => {
      const address = target === SCENE ? exports.scene_closest(batch, mask) : exports.closest(target, batch);
      read(exports, address, batch, hits, first);
    });
    return hits;
  }

  any(target, rays, occluded, mask) {
    // Throws if it was freed.
    void this.exports;
    const count = checkRays(rays);
    if (occluded === undefined) {
      occluded = new Uint8Array(count);
    } else {
      checkType("occluded", occluded, Uint8Array);
      checkLength("occluded", occluded, count, "rays");
    }
    this.#trace(rays, count, (exports, first, batch) => {
      const address = target === SCENE ? exports.scene_any(batch, mask) : exports.any(target, batch);
      occluded.set(new Uint8Array(exports.memory.buffer, address >>> 0, batch), first);
    });
    return occluded;
  }

  allHits(target, rays, most, mask) {
    // Throws if it was freed.
    void this.exports;
    const count = checkRays(rays);
    if (!(Number.isInteger(most) && most >= 1) && most !== Infinity) {
      throw new RangeError(`most is ${most}, and should be a whole number from 1 on, or Infinity`);
    }
    const starts = new Uint32Array(count + 1);
    const parts = [];
    this.#trace(rays, count, (exports, first, batch) => {
      const limit = Math.min(most, ALL);
      const address =
        (target === SCENE ? exports.scene_all_hits(batch, limit, mask) : exports.all_hits(target, batch, limit)) >>> 0;
      const ends = new Uint32Array(exports.memory.buffer, address, batch);
      const [before, found] = [starts[first], ends[batch - 1]];
      ends.forEach((end, i) => (starts[first + i + 1] = before + end));
      const part = hitsFor(found, target);
      read(exports, address + 4 * batch, found, part, 0);
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

  closestPoint(target, points, radius, mask) {
    // Throws if it was freed.
    void this.exports;
    const count = checkPoints(points);
    checkRadius(radius);
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
          (target === SCENE ? exports.scene_closest_points(batch, mask) : exports.closest_points(target, batch)) >>> 0;
        const columns = read(exports, address, batch, { ...found, t: distance }, first);
        found.position.set(new Float32Array(exports.memory.buffer, address + 4 * columns * batch, 3 * batch), 3 * first);
      });
    }
    return found;
  }

  /** Has `answer` take every batch of the rays. */
  #trace(rays, count, answer) {
    for (let first = 0; first < count; first += BATCH) {
      const batch = Math.min(BATCH, count - first);
      this.attempt((exports) => {
        write(exports, this.#rays, rays.subarray(RAY_FLOATS * first, RAY_FLOATS * (first + batch)));
        answer(exports, first, batch);
      });
    }
  }
}

class Tree {
  #engine;
  #triangles;

  constructor(engine) {
    this.#engine = engine;
    this.#triangles = engine.exports.triangles(0);
  }

  get triangles() {
    return this.#triangles;
  }

  get bytes() {
    return this.#engine.exports.bytes(0) >>> 0;
  }

  get simd() {
    return this.#engine.simd;
  }

  closest(rays, hits = undefined) {
    return this.#engine.closest(0, rays, hits, ALL);
  }

  any(rays, occluded = undefined) {
    return this.#engine.any(0, rays, occluded, ALL);
  }

  allHits(rays, { most = Infinity } = {}) {
    return this.#engine.allHits(0, rays, most, ALL);
  }

  closestPoint(points, { radius = Infinity } = {}) {
    return this.#engine.closestPoint(0, points, radius, ALL);
  }

  refit(positions, indices = null) {
    return this.#engine.refit(0, positions, indices);
  }

  free() {
    this.#engine.free();
  }
}

class Scene {
  #engine;
  /** By their numbers. */
  #instances = new Map();

  constructor(engine) {
    this.#engine = engine;
  }

  get simd() {
    return this.#engine.simd;
  }

  addMesh(positions, indices = null, options = {}) {
    return new Mesh(this.#engine, this.#engine.addMesh(positions, indices, options));
  }

  insert(mesh, { transform = IDENTITY, mask = ALL } = {}) {
    const number = meshNumber(mesh, this.#engine);
    checkMask(mask);
    const exports = this.#engine.writeMatrix(transform);
    const index = this.#engine.attempt(() => exports.insert(number, mask));
    if (index < 0) {
      throw nearlyFlat();
    }
    const instance = new Instance(this.#engine, index, mesh, () => this.#instances.delete(index));
    this.#instances.set(index, instance);
    return instance;
  }

  instance(number) {
    return this.#instances.get(number);
  }

  commit() {
    const seen = this.#engine.attempt((exports) => exports.commit());
    if (seen < 0) {
      throw new RangeError("the scene has more than a tree can hold");
    }
    return seen;
  }

  closest(rays, { hits = undefined, mask = ALL } = {}) {
    return this.#engine.closest(SCENE, rays, hits, checkMask(mask));
  }

  any(rays, { occluded = undefined, mask = ALL } = {}) {
    return this.#engine.any(SCENE, rays, occluded, checkMask(mask));
  }

  allHits(rays, { most = Infinity, mask = ALL } = {}) {
    return this.#engine.allHits(SCENE, rays, most, checkMask(mask));
  }

  closestPoint(points, { radius = Infinity, mask = ALL } = {}) {
    return this.#engine.closestPoint(SCENE, points, radius, checkMask(mask));
  }

  free() {
    this.#engine.free();
  }
}

class Mesh {
  #engine;
  #number;

  constructor(engine, number) {
    this.#engine = engine;
    this.#number = number;
  }

  get triangles() {
    return this.#engine.exports.triangles(this.#number);
  }

  get bytes() {
    return this.#engine.exports.bytes(this.#number) >>> 0;
  }

  refit(positions, indices = null) {
    return this.#engine.refit(this.#number, positions, indices);
  }

  /** The number of a mesh that this scene has. */
  static numberIn(mesh, engine) {
    return typeof mesh === "object" && mesh !== null && #number in mesh && mesh.#engine === engine ? mesh.#number : null;
  }
}

function meshNumber(mesh, engine) {
  const number = Mesh.numberIn(mesh, engine);
  if (number === null) {
    throw new TypeError("mesh should be one that addMesh of this scene gave");
  }
  return number;
}

class Instance {
  #engine;
  #number;
  #mesh;
  #forget;

  constructor(engine, number, mesh, forget) {
    this.#engine = engine;
    this.#number = number;
    this.#mesh = mesh;
    this.#forget = forget;
  }

  get number() {
    return this.#number;
  }

  get mesh() {
    return this.#mesh;
  }

  setTransform(matrix) {
    const number = this.#there();
    if (this.#engine.writeMatrix(matrix).set_transform(number) < 0) {
      throw nearlyFlat();
    }
  }

  setMask(mask) {
    this.#engine.exports.set_mask(this.#there(), checkMask(mask));
  }

  setMesh(mesh) {
    this.#engine.exports.set_mesh(this.#there(), meshNumber(mesh, this.#engine));
    this.#mesh = mesh;
  }

  remove() {
    this.#engine.exports.remove(this.#there());
    this.#forget();
    this.#forget = null;
  }

  #there() {
    if (this.#forget === null) {
      throw new TypeError("this instance was removed");
    }
    return this.#number;
  }
}

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

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

function nearlyFlat() {
  return new RangeError("the transform is nearly flat: it should have an inverse, or scale by exactly 0, which hides");
}
