// Trees over triangle meshes and scenes of them, traced in WebAssembly. index.d.ts says what everything is.
//
// Every tree and every scene has an instance of its own: what goes wrong in one stays there, and its memory goes away with it.

import { checkMask, checkMesh, checkTransforms, qualityNumber, RAY_FLOATS } from "./checks.js";
import { ALL, instantiate, refusedTransform, SCENE } from "./engine.js";
import { hasSimd } from "./simd.js";

export { hasSimd, RAY_FLOATS };

export async function build(positions, indices = null, options = {}) {
  indices ??= null;
  checkMesh(positions, indices);
  qualityNumber(options);
  // Copies, as the arrays may change or go while the module is loaded.
  positions = new Float32Array(positions);
  indices = indices === null ? null : new Uint32Array(indices);
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

  closest(rays, options) {
    const { hits, filter } = options ?? {};
    return this.#engine.closest(0, rays, { hits, filter });
  }

  any(rays, options) {
    const { occluded, filter } = options ?? {};
    return this.#engine.any(0, rays, { occluded, filter });
  }

  allHits(rays, options) {
    const { most } = options ?? {};
    return this.#engine.allHits(0, rays, { most });
  }

  closestPoint(points, options) {
    const { radius } = options ?? {};
    return this.#engine.closestPoint(0, points, { radius });
  }

  refit(positions, indices = null) {
    return this.#engine.refit(0, positions, indices ?? null);
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
    return new Mesh(this.#engine, this.#engine.addMesh(positions, indices ?? null, options));
  }

  addMovingMesh(keys, indices = null, options = {}) {
    return new Mesh(this.#engine, this.#engine.addMovingMesh(keys, indices ?? null, options), "has keys");
  }

  addRound(kind, numbers, options = {}) {
    return new Mesh(this.#engine, this.#engine.addRound(kind, numbers, options), "is of points or curves");
  }

  insert(mesh, options) {
    const { transform = IDENTITY, transforms = [transform], mask = ALL } = options ?? {};
    const number = meshNumber(mesh, this.#engine);
    checkMask(mask);
    const exports = this.#engine.writeMatrices(checkTransforms(transforms));
    const index = this.#engine.attempt(() => exports.insert(number, mask));
    if (index < 0) {
      throw refusedTransform(index, transforms.length);
    }
    Mesh.use(mesh, 1);
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

  closest(rays, options) {
    return this.#engine.closest(SCENE, rays, options ?? {});
  }

  any(rays, options) {
    return this.#engine.any(SCENE, rays, options ?? {});
  }

  allHits(rays, options) {
    const { most, mask, time } = options ?? {};
    return this.#engine.allHits(SCENE, rays, { most, mask, time });
  }

  closestPoint(points, options) {
    return this.#engine.closestPoint(SCENE, points, options ?? {});
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
  #instances = 0;

  constructor(engine, number, fixed = null) {
    this.#engine = engine;
    this.#number = number;
    this.#fixed = fixed;
  }

  get triangles() {
    return this.#engine.exports.triangles(this.#there());
  }

  get bytes() {
    return this.#engine.exports.bytes(this.#there()) >>> 0;
  }

  get instances() {
    return this.#instances;
  }

  refit(positions, indices = null) {
    if (this.#fixed !== null) {
      throw new TypeError(`this mesh ${this.#fixed}, and takes no positions: add a new one`);
    }
    return this.#engine.refit(this.#there(), positions, indices ?? null);
  }

  free() {
    if (this.#number === null) {
      return;
    }
    if (this.#instances > 0) {
      const [count, them] = this.#instances === 1 ? ["an instance shows", "it"] : [`${this.#instances} instances show`, "them"];
      throw new TypeError(`${count} this mesh: remove ${them} before it is freed, or call setMesh`);
    }
    this.#engine.exports.free_mesh(this.#number);
    this.#number = null;
  }

  #there() {
    if (this.#number === null) {
      throw new TypeError("this mesh was freed");
    }
    return this.#number;
  }

  /** The number of a mesh that this scene has. */
  static numberIn(mesh, engine) {
    return typeof mesh === "object" && mesh !== null && #number in mesh && mesh.#engine === engine ? mesh.#there() : null;
  }

  /** Counts instances that show it. */
  static use(mesh, more) {
    mesh.#instances += more;
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
    const exports = this.#engine.writeMatrices(checkTransforms(matrices));
    const done = this.#engine.attempt(() => exports.set_transform(number));
    if (done < 0) {
      throw refusedTransform(done, matrices.length);
    }
  }

  setMask(mask) {
    this.#engine.exports.set_mask(this.#there(), checkMask(mask));
  }

  setMesh(mesh) {
    const number = meshNumber(mesh, this.#engine);
    this.#engine.attempt((exports) => exports.set_mesh(this.#there(), number));
    Mesh.use(this.#mesh, -1);
    Mesh.use(mesh, 1);
    this.#mesh = mesh;
  }

  remove() {
    this.#engine.attempt((exports) => exports.remove(this.#there()));
    Mesh.use(this.#mesh, -1);
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
