// Trees over triangle meshes and scenes of them, traced in WebAssembly. index.d.ts says what everything is.
//
// Every tree and every scene has an instance of its own: what goes wrong in one stays there, and its memory goes away with it.

import { checkMask, checkMesh, checkTransforms, qualityNumber, RAY_FLOATS } from "./checks.js";
import { ALL, instantiate, nearlyFlat, SCENE } from "./engine.js";
import { hasSimd } from "./simd.js";

export { hasSimd, RAY_FLOATS };

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

  closest(rays, { hits, filter } = {}) {
    return this.#engine.closest(0, rays, { hits, filter });
  }

  any(rays, { occluded, filter } = {}) {
    return this.#engine.any(0, rays, { occluded, filter });
  }

  allHits(rays, { most } = {}) {
    return this.#engine.allHits(0, rays, { most });
  }

  closestPoint(points, { radius } = {}) {
    return this.#engine.closestPoint(0, points, { radius });
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

  addMovingMesh(keys, indices = null, options = {}) {
    return new Mesh(this.#engine, this.#engine.addMovingMesh(keys, indices, options), "has keys");
  }

  addRound(kind, numbers, options = {}) {
    return new Mesh(this.#engine, this.#engine.addRound(kind, numbers, options), "is of points or curves");
  }

  insert(mesh, { transform = IDENTITY, transforms = [transform], mask = ALL } = {}) {
    const number = meshNumber(mesh, this.#engine);
    checkMask(mask);
    const exports = this.#engine.writeMatrices(checkTransforms(transforms));
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

  closest(rays, options = {}) {
    return this.#engine.closest(SCENE, rays, options);
  }

  any(rays, options = {}) {
    return this.#engine.any(SCENE, rays, options);
  }

  allHits(rays, { most, mask, time } = {}) {
    return this.#engine.allHits(SCENE, rays, { most, mask, time });
  }

  closestPoint(points, options = {}) {
    return this.#engine.closestPoint(SCENE, points, options);
  }

  free() {
    this.#engine.free();
  }
}

class Mesh {
  #engine;
  #number;
  /** Why it cannot be refitted; null if it can. */
  #fixed;

  constructor(engine, number, fixed = null) {
    this.#engine = engine;
    this.#number = number;
    this.#fixed = fixed;
  }

  get triangles() {
    return this.#engine.exports.triangles(this.#number);
  }

  get bytes() {
    return this.#engine.exports.bytes(this.#number) >>> 0;
  }

  refit(positions, indices = null) {
    if (this.#fixed !== null) {
      throw new TypeError(`this mesh ${this.#fixed}, and takes no positions: add a new one`);
    }
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
    throw new TypeError("mesh should be one that addMesh, addMovingMesh or addRound of this scene gave");
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
    this.setTransforms([matrix]);
  }

  setTransforms(matrices) {
    const number = this.#there();
    if (this.#engine.writeMatrices(checkTransforms(matrices)).set_transform(number) < 0) {
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
