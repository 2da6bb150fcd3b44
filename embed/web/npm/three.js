// What three.js has, as the package takes it. It uses the methods of the objects that it is given, and does not import three.js.

/** The positions and indices of a BufferGeometry: its own arrays where they suit, else copies. Morph targets do not count. */
export function meshOf(geometry) {
  const position = geometry?.attributes?.position;
  if (position === undefined) {
    throw new TypeError("geometry should be a BufferGeometry with an attribute `position`");
  }
  const plain = position.array instanceof Float32Array && position.itemSize === 3 && !position.isInterleavedBufferAttribute;
  let positions = position.array;
  if (!plain) {
    positions = new Float32Array(3 * position.count);
    for (let i = 0; i < position.count; i++) {
      positions.set([position.getX(i), position.getY(i), position.getZ(i)], 3 * i);
    }
  }
  const index = geometry.index?.array ?? null;
  const suits = index === null || index instanceof Uint32Array || index instanceof Uint16Array;
  let indices = suits ? index : new Uint32Array(index);
  if (indices === null && positions.length % 9 !== 0) {
    // three.js leaves out vertices at the end that are not three.
    positions = positions.subarray(0, positions.length - (positions.length % 9));
  }
  return { positions, indices };
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
 * Inserts all meshes below an object into a scene, InstancedMesh too, at their places in the world. A geometry that several
 * have is there once. `update` moves them to where they are now, `objectOf` says whose a hit's instance is; both are followed
 * by a commit of the caller's, as all changes are.
 */
export function insertObject(scene, root, { quality = "high", mask = 0xffffffff } = {}) {
  const meshes = new Map();
  const entries = [];
  root.updateWorldMatrix(true, true);
  root.traverse((object) => {
    if (!object.isMesh) {
      return;
    }
    if (!meshes.has(object.geometry)) {
      const { positions, indices } = meshOf(object.geometry);
      meshes.set(object.geometry, scene.addMesh(positions, indices, { quality }));
    }
    const mesh = meshes.get(object.geometry);
    for (let index = 0; index < (object.isInstancedMesh ? object.count : 1); index++) {
      const instance = scene.insert(mesh, { transform: placeOf(object, index), mask });
      entries.push({ instance, object, index });
    }
  });
  const byInstance = new Map(entries.map((entry) => [entry.instance, entry]));
  return {
    entries,
    /** The three.js object of a hit's instance, and its index in an InstancedMesh. */
    objectOf: (number) => byInstance.get(scene.instance(number)),
    /** Moves everything to where it is now. */
    update() {
      root.updateWorldMatrix(true, true);
      entries.forEach(({ instance, object, index }) => instance.setTransform(placeOf(object, index)));
    },
    remove: () => entries.forEach(({ instance }) => instance.remove()),
  };
}

/** The matrix of an object in the world, or of one of its instances. */
function placeOf(object, index) {
  if (!object.isInstancedMesh) {
    return object.matrixWorld.elements;
  }
  const own = object.matrixWorld.clone();
  object.getMatrixAt(index, own);
  return own.premultiply(object.matrixWorld).elements;
}
