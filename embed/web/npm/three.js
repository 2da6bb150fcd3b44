// What three.js has, as the package takes it. It uses the methods of the objects that it is given, and does not import three.js.

import { isTyped } from "./checks.js";

/** The positions and indices of a BufferGeometry: its own arrays where they suit, else copies. Morph targets do not count. */
export function meshOf(geometry) {
  const positions = positionsOf(geometry);
  const indices = indicesOf(geometry);
  const count = indices?.length ?? positions.length / 3;
  const { start = 0, count: length = Infinity } = geometry.drawRange ?? {};
  const first = Math.max(0, start);
  // three.js leaves out vertices at the end that are not three.
  const end = first + 3 * Math.max(0, Math.floor((Math.min(count, start + length) - first) / 3));
  if (first === 0) {
    return indices === null ? { positions: cut(positions, 3 * end), indices } : { positions, indices: cut(indices, end) };
  }
  // Folded triangles, which cannot be hit, stand for those before, so that the others keep their numbers.
  const before = 3 * Math.floor(first / 3);
  const drawn = new Uint32Array(before + end - first);
  for (let i = first; i < end; i++) {
    drawn[before + i - first] = indices === null ? i : indices[i];
  }
  return { positions, indices: end > first ? drawn : drawn.subarray(0, 0) };
}

function positionsOf(geometry) {
  const position = geometry?.attributes?.position;
  if (position === undefined) {
    throw new TypeError("geometry should be a BufferGeometry with an attribute `position`");
  }
  if (isTyped(position.array, Float32Array) && position.itemSize === 3 && !position.isInterleavedBufferAttribute) {
    return position.array;
  }
  const positions = new Float32Array(3 * position.count);
  for (let i = 0; i < position.count; i++) {
    positions.set([position.getX(i), position.getY(i), position.getZ(i)], 3 * i);
  }
  return positions;
}

function indicesOf(geometry) {
  const index = geometry.index?.array ?? null;
  const suits = index === null || isTyped(index, Uint32Array) || isTyped(index, Uint16Array);
  return suits ? index : new Uint32Array(index);
}

function cut(array, length) {
  return length < array.length ? array.subarray(0, length) : array;
}

/** Rays of three.js (`origin`, `direction`) in one array, as trees and scenes trace them. */
export function raysOf(rays, near = 0, far = Infinity) {
  const numbers = new Float32Array(8 * rays.length);
  rays.forEach(({ origin, direction }, i) => {
    numbers.set([origin.x, origin.y, origin.z, near, direction.x, direction.y, direction.z, far], 8 * i);
  });
  return numbers;
}

/**
 * Inserts all meshes below an object into a scene, InstancedMesh and BatchedMesh too, at their places in the world. A geometry
 * that several have is there once. `update` follows them, `objectOf` says whose a hit's instance is; both go with a commit of the
 * caller's, as all changes do.
 */
export function insertObject(scene, root, options) {
  const { quality = "high", mask = 0xffffffff } = options ?? {};
  const placed = new PlacedObjects(scene, { quality, mask });
  const skipped = [];
  const objects = [];
  root.traverse((object) => {
    if (object.isMesh) {
      (isLeftOut(object) ? skipped : objects).push(object);
    }
  });
  if (skipped.length > 0) {
    const kinds = [...new Set(skipped.map((object) => (object.isSkinnedMesh ? "SkinnedMesh" : "BatchedMesh")))].join(", ");
    console.warn(`halfdome leaves out objects, as it does not know where their triangles are: ${skipped.length} of ${kinds}`);
  }
  const update = () => {
    root.updateWorldMatrix(true, true);
    objects.forEach((object) => placed.follow(object));
  };
  try {
    update();
  } catch (error) {
    try {
      placed.remove();
    } catch {
      // The scene is lost, which the first error says.
    }
    throw error;
  }
  return {
    get entries() {
      return placed.entries();
    },
    skipped,
    objectOf: (number) => placed.entryOf(number),
    update,
    remove: () => placed.remove(),
  };
}

/** Bones move the vertices of the one; the others have had other methods. */
function isLeftOut(object) {
  return object.isSkinnedMesh || (object.isBatchedMesh && typeof object.getGeometryRangeAt !== "function");
}

/** What a scene has of objects: their meshes, and an instance for each of theirs. */
class PlacedObjects {
  #scene;
  #options;
  /** By geometries, and in a BatchedMesh by its number of a geometry. */
  #meshes = new Map();
  /** By objects, and there by their own indices. */
  #entries = new Map();
  #byInstance = new Map();

  constructor(scene, options) {
    this.#scene = scene;
    this.#options = options;
  }

  entries() {
    return [...this.#byInstance.values()];
  }

  entryOf(number) {
    return this.#byInstance.get(this.#scene.instance(number));
  }

  /** Moves an object's instances to where they are now, with those that came, without those that went. */
  follow(object) {
    try {
      const entries = this.#entries.get(object) ?? new Map();
      this.#entries.set(object, entries);
      let count = 0;
      for (const { index, geometryId, transform } of instancesOf(object)) {
        this.#place(entries, { object, index, geometryId, transform });
        count += 1;
      }
      if (count < entries.size) {
        const left = new Set([...instancesOf(object)].map(({ index }) => index));
        const gone = [...entries.values()].filter(({ index }) => !left.has(index));
        gone.forEach((entry) => this.#removeInstance(entry));
        gone.forEach(({ index }) => entries.delete(index));
      }
    } catch (error) {
      error.message = `${object.type} ${JSON.stringify(object.name)}: ${error.message}`;
      throw error;
    }
  }

  #place(entries, { object, index, geometryId, transform }) {
    const entry = entries.get(index);
    if (entry === undefined) {
      const { mesh, firstTriangle } = this.#meshOf(object, geometryId);
      const instance = this.#scene.insert(mesh, { transform, mask: this.#options.mask });
      entries.set(index, { instance, object, index, firstTriangle });
      this.#byInstance.set(instance, entries.get(index));
      return;
    }
    entry.instance.setTransform(transform);
    if (geometryId !== null) {
      const { mesh, firstTriangle } = this.#meshOf(object, geometryId);
      entry.firstTriangle = firstTriangle;
      if (entry.instance.mesh !== mesh) {
        entry.instance.setMesh(mesh);
      }
    }
  }

  /** Removes all instances, and frees the meshes that no others show. */
  remove() {
    this.#byInstance.forEach((entry) => this.#removeInstance(entry));
    this.#entries.clear();
    for (const own of this.#meshes.values()) {
      own.forEach(({ mesh }) => mesh.instances === 0 && mesh.free());
    }
    this.#meshes.clear();
  }

  #removeInstance({ instance }) {
    this.#byInstance.delete(instance);
    // Unless the caller did so.
    if (this.#scene.instance(instance.number) === instance) {
      instance.remove();
    }
  }

  #meshOf(object, geometryId) {
    const { geometry } = object;
    const own = this.#meshes.get(geometry) ?? new Map();
    this.#meshes.set(geometry, own);
    if (!own.has(geometryId)) {
      const { positions, indices, firstTriangle = 0 } = geometryId === null ? meshOf(geometry) : batchedMesh(object, geometryId);
      own.set(geometryId, { mesh: this.#scene.addMesh(positions, indices, { quality: this.#options.quality }), firstTriangle });
    }
    return own.get(geometryId);
  }
}

/** What an object is there as: its own indices, the numbers of geometries in a BatchedMesh, and matrices in the world. */
function* instancesOf(object) {
  if (object.isBatchedMesh) {
    const matrix = object.matrixWorld.clone();
    for (const index of batchedInstances(object)) {
      const geometryId = object.getGeometryIdAt(index);
      object.getMatrixAt(index, matrix);
      yield { index, geometryId, transform: matrix.premultiply(object.matrixWorld).elements };
    }
  } else if (object.isInstancedMesh) {
    const matrix = object.matrixWorld.clone();
    for (let index = 0; index < object.count; index++) {
      object.getMatrixAt(index, matrix);
      yield { index, geometryId: null, transform: matrix.premultiply(object.matrixWorld).elements };
    }
  } else {
    yield { index: 0, geometryId: null, transform: object.matrixWorld.elements };
  }
}

/** The numbers of a BatchedMesh's instances that are seen. Some of them may be free. */
function* batchedInstances(object) {
  for (let [index, found] = [0, 0]; found < object.instanceCount && index < object.maxInstanceCount; index++) {
    let visible;
    try {
      visible = object.getVisibleAt(index);
    } catch {
      continue;
    }
    found += 1;
    if (visible) {
      yield index;
    }
  }
}

/** A geometry of a BatchedMesh, and the number of its first triangle there. */
function batchedMesh(object, geometryId) {
  const { geometry } = object;
  const { vertexStart, vertexCount, start, count } = object.getGeometryRangeAt(geometryId);
  const indices = indicesOf(geometry);
  return {
    positions: positionsOf(geometry).slice(3 * vertexStart, 3 * (vertexStart + vertexCount)),
    indices: indices === null ? null : indices.slice(start, start + count).map((vertex) => vertex - vertexStart),
    firstTriangle: Math.floor(start / 3),
  };
}
