// Runs under `node --test`: all hits, closest points, refits and scenes that change, against loops in double precision.
import assert from "node:assert/strict";
import { test } from "node:test";

import { build, createScene, hasSimd } from "./index.js";

/** Right triangles (0, 0), (1, 0), (0, 1) at z = 0, -1, -2 … */
function layers(count, x = 0) {
  return new Float32Array(Array.from({ length: count }, (_, i) => [x, 0, -i, x + 1, 0, -i, x, 1, -i]).flat());
}

/** A ray straight down at x + 0.25 and y = 0.25. */
const downAt = (...xs) => new Float32Array(xs.flatMap((x) => [x + 0.25, 0.25, 2, 0, 0, 0, -1, Infinity]));

const moved = (x, y = 0, z = 0) => [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1];

const scaled = (x, y, z) => [x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1];

const refuses = (type, message) => (error) => {
  assert.ok(error instanceof type && error.message === message, `${error}`);
  return true;
};

test("all hits are in order, or the nearest few", async () => {
  for (const simd of [false, true]) {
    const tree = await build(layers(40), null, { simd });
    const { starts, t, u, v, triangle } = tree.allHits(downAt(0, 9, 0));
    assert.deepEqual([...starts], [0, 40, 40, 80]);
    for (let i = 0; i < 80; i++) {
      assert.deepEqual([t[i], u[i], v[i], triangle[i]], [2 + (i % 40), 0.25, 0.25, i % 40]);
    }
    const few = tree.allHits(downAt(0, 9, 0), { most: 3 });
    assert.deepEqual([...few.starts], [0, 3, 3, 6]);
    assert.deepEqual([...few.triangle], [0, 1, 2, 0, 1, 2]);
    assert.deepEqual([...tree.allHits(new Float32Array(0)).starts], [0]);
    // More rays than go over at once.
    const rays = new Float32Array(8 * 9001);
    for (let i = 0; i < 9001; i++) {
      rays.set(downAt(i % 3 ? 9 : 0), 8 * i);
    }
    const many = tree.allHits(rays, { most: 2 });
    assert.equal(many.starts[9001], 2 * 3001);
    assert.ok(many.starts.every((start, i) => start === 2 * Math.ceil(i / 3)));
    assert.ok(many.triangle.every((triangle, i) => triangle === i % 2));
    assert.throws(() => tree.allHits(downAt(0), { most: 0 }), refuses(RangeError, "most is 0, and should be a whole number from 1 on, or Infinity"));
  }
});

test("closest points", async () => {
  const tree = await build(layers(6));
  const points = new Float32Array([0.25, 0.25, 2, -3, 0, -6, 0.5, 0.25, -2.25]);
  const found = tree.closestPoint(points);
  assert.deepEqual([...found.triangle], [0, 5, 2]);
  assert.deepEqual([...found.position], [0.25, 0.25, 0, 0, 0, -5, 0.5, 0.25, -2]);
  assert.deepEqual([...found.distance].map((d) => Math.round(1e4 * d)), [20000, Math.round(1e4 * Math.sqrt(10)), 2500]);
  const near = tree.closestPoint(points, { radius: 1 });
  assert.deepEqual([...near.triangle], [-1, -1, 2]);
  assert.ok(Number.isNaN(near.position[0]) && near.distance[0] === Infinity);
  assert.equal(tree.closestPoint(new Float32Array(3 * 5000)).triangle.length, 5000);
  for (const [call, type, message] of [
    [() => tree.closestPoint([0, 0, 0]), TypeError, "points is an Array, and should be a Float32Array"],
    [() => tree.closestPoint(new Float32Array(4)), RangeError, "points has 4 numbers, which are not a multiple of 3"],
    [() => tree.closestPoint(new Float32Array([0, 0, 0, 0, NaN, 0])), RangeError, "points[4], of point 1, is NaN"],
    [() => tree.closestPoint(points, { radius: -1 }), RangeError, "radius is -1, and should be 0 or more; it may be Infinity"],
  ]) {
    assert.throws(call, refuses(type, message));
  }
});

test("a refit follows the triangles, or leaves the tree as it was", async () => {
  const tree = await build(layers(6));
  const decay = tree.refit(layers(6, 7));
  assert.ok(decay > 0.99 && decay < 1.01, `${decay}`);
  assert.deepEqual([...tree.closest(downAt(0, 7)).triangle], [-1, 0]);
  const message =
    "the triangles are not those of the tree: as many are needed, in the same order, of which the same ones have an area";
  assert.throws(() => tree.refit(layers(5, 9)), refuses(RangeError, message));
  assert.throws(() => tree.refit(new Float32Array(54)), refuses(RangeError, message));
  assert.throws(() => tree.refit(layers(6).fill(NaN, 3, 4)), RangeError);
  assert.deepEqual([...tree.closest(downAt(0, 7)).triangle], [-1, 0]);
});

for (const simd of [false, true]) {
  test(`a scene changes at its commits, ${simd ? "with" : "without"} SIMD`, async () => {
    const scene = await createScene({ simd });
    assert.equal(scene.simd, simd && hasSimd());
    const mesh = scene.addMesh(layers(2));
    const other = scene.addMesh(layers(1), new Uint16Array([0, 2, 1]), { quality: "fast" });
    assert.deepEqual([mesh.triangles, other.triangles], [2, 1]);
    const seen = (xs, options) => [...scene.closest(downAt(...xs), options).instance];
    const instances = Array.from({ length: 10 }, (_, i) => scene.insert(mesh, { transform: moved(2 * i), mask: i === 4 ? 2 : 1 }));
    assert.deepEqual(seen([0, 8]), [-1, -1]);
    assert.equal(scene.commit(), 10);
    assert.deepEqual(seen([0, 8, 18, 20]), [0, 4, 9, -1]);
    assert.deepEqual(seen([0, 8], { mask: 1 }), [0, -1]);
    assert.equal(scene.instance(9), instances[9]);
    assert.deepEqual([...scene.any(downAt(0, 8, 20), { mask: 1 })], [1, 0, 0]);

    instances[0].setTransform(moved(100, 0, -3));
    instances[4].setMask(3);
    instances[5].setTransform(new Float32Array(16).fill(0).fill(1, 15));
    instances[6].setMesh(other);
    instances[7].remove();
    assert.deepEqual(seen([0, 8, 10, 14]), [0, 4, 5, 7]);
    assert.equal(scene.commit(), 8);
    assert.deepEqual(seen([0, 8, 10, 14, 100]), [-1, 4, -1, -1, 0]);
    assert.equal(scene.closest(downAt(100)).t[0], 5);
    assert.deepEqual([...scene.allHits(downAt(2, 12, 14)).starts], [0, 2, 3, 3]);
    const all = scene.allHits(downAt(2, 12));
    assert.deepEqual([[...all.triangle], [...all.instance]], [[0, 1, 0], [1, 1, 6]]);

    // Its number is used again, the instance is not.
    assert.equal(scene.instance(7), undefined);
    assert.throws(() => instances[7].remove(), refuses(TypeError, "this instance was removed"));
    assert.throws(() => instances[7].setMask(1), refuses(TypeError, "this instance was removed"));
    const again = scene.insert(other, { transform: moved(14) });
    assert.equal(again.number, 7);
    scene.commit();
    assert.equal(scene.instance(seen([14])[0]), again);
    assert.throws(() => instances[7].setTransform(moved(0)), TypeError);

    const { position, instance, distance } = scene.closestPoint(new Float32Array([98, 0, -3, 0, 0, 0]));
    assert.deepEqual([[...position.subarray(0, 3)], [...instance], [...distance]], [[100, 0, -3], [0, 1], [2, 2]]);
    assert.deepEqual([...scene.closestPoint(new Float32Array([8, 0, 0]), { mask: 2, radius: 1 }).instance], [4]);

    // All instances of a mesh follow it.
    assert.ok(mesh.refit(layers(2, 0.5)) > 0);
    assert.deepEqual(seen([2.5, 3.5]), [1, -1]);
    scene.commit();
    assert.deepEqual(seen([2, 2.5, 12, 14]), [-1, 1, 6, 7]);
    mesh.refit(layers(2));
    scene.commit();
    assert.deepEqual(seen([2, 2.5]), [1, 1]);
  });
}

test("wrong arguments have errors that say what would be right, and leave the scene as it was", async () => {
  const scene = await createScene();
  const mesh = scene.addMesh(layers(1));
  const stranger = (await createScene()).addMesh(layers(1));
  const instance = scene.insert(mesh);
  scene.commit();
  const flat = moved(0);
  flat[0] = 1e-6;
  const inMesh = "mesh should be one that addMesh, addMovingMesh or addRound of this scene gave";
  for (const [call, type, message] of [
    [() => scene.addMesh([1, 2, 3]), TypeError, "positions is an Array, and should be a Float32Array"],
    [() => scene.addMesh(layers(1), null, { quality: "best" }), RangeError, 'quality is "best", and should be one of fast, medium, high'],
    [() => scene.insert(null), TypeError, inMesh],
    [() => scene.insert({}), TypeError, inMesh],
    [() => scene.insert(stranger), TypeError, inMesh],
    [() => instance.setMesh(stranger), TypeError, inMesh],
    [() => scene.insert(mesh, { mask: -1 }), RangeError, "mask is -1, and should be a whole number of 32 bits"],
    [() => instance.setMask(0.5), RangeError, "mask is 0.5, and should be a whole number of 32 bits"],
    [() => instance.setTransform(null), TypeError, "transform is null, and should be 16 numbers, column by column"],
    [() => instance.setTransform([1, 2]), TypeError, "transform is an Array, and should be 16 numbers, column by column"],
    [() => instance.setTransform(moved(NaN)), RangeError, "transform[12] is NaN, and should be a finite number"],
    [() => instance.setTransform(moved(1e300)), RangeError, "transform[12] is 1e+300, and should be a finite number"],
    [() => instance.setTransform([...moved(0).slice(0, 15), 2]), RangeError, "the last row of transform is 0, 0, 0, 2, and should be 0, 0, 0, 1"],
    [() => instance.setTransform(flat), RangeError, "the transform is nearly flat: it should have an inverse, or scale by exactly 0, which hides"],
    [() => scene.closest(downAt(0), { hits: 7 }), TypeError, "hits is 7, and should hold the arrays t, u, v, triangle and instance"],
    [() => scene.any(downAt(0), { mask: "1" }), RangeError, "mask is 1, and should be a whole number of 32 bits"],
  ]) {
    assert.throws(call, refuses(type, message));
    scene.commit();
    assert.deepEqual([...scene.closest(downAt(0)).instance], [0]);
  }
  scene.free();
  assert.throws(() => scene.closest(downAt(0)), refuses(TypeError, "this scene was freed"));
  assert.throws(() => instance.setMask(1), refuses(TypeError, "this scene was freed"));
});

test("a filter lets rays go on, past many hits too", async () => {
  for (const simd of [false, true]) {
    const tree = await build(layers(40), null, { simd });
    const seen = [];
    const filter = ({ ray, triangle, t, u, v }) => {
      seen.push([ray, triangle]);
      assert.deepEqual([t, u, v], [2 + triangle, 0.25, 0.25]);
      return triangle === [0, 30, 99, 5][ray];
    };
    const rays = downAt(0, 0, 0, 0, 9);
    assert.deepEqual([...tree.closest(rays, { filter }).triangle], [0, 30, -1, 5, -1]);
    // Each hit is judged once, nearest first.
    const ofRay = (ray) => seen.filter(([number]) => number === ray).map(([, triangle]) => triangle);
    const upTo = (count) => Array.from({ length: count }, (_, i) => i);
    assert.deepEqual([0, 1, 2, 3, 4].map(ofRay), [1, 31, 40, 6, 0].map(upTo));
    assert.deepEqual([...tree.any(rays, { filter })], [1, 1, 0, 1, 0]);
    const scene = await createScene({ simd });
    const mesh = scene.addMesh(layers(2));
    [0, 0, 8].forEach((x) => scene.insert(mesh, { transform: moved(x) }));
    scene.commit();
    const last = scene.closest(downAt(0, 8), { filter: ({ ray, instance, triangle }) => ray === 1 || (instance === 1 && triangle === 1) });
    assert.deepEqual([[...last.instance], [...last.triangle]], [[1, 2], [1, 0]]);
    assert.throws(() => tree.any(rays, { filter: 1 }), refuses(TypeError, "filter is 1, and should be a function"));
    assert.throws(() => tree.closest(rays, { filter: () => { throw new Error("mine"); } }), /mine/);
    assert.equal(tree.closest(rays).triangle[0], 0);
  }
});

test("what moves while the shutter is open is where rays have their time", async () => {
  for (const simd of [false, true]) {
    const scene = await createScene({ simd });
    const slides = scene.insert(scene.addMesh(layers(1)), { transforms: [moved(0), moved(8)] });
    const sinks = scene.addMovingMesh([layers(1, 20), layers(1, 20).map((x, i) => (i % 3 === 2 ? x - 4 : x))]);
    assert.deepEqual([sinks.triangles, scene.insert(sinks).number], [1, 1]);
    scene.commit();
    const at = (xs, time, more = {}) => {
      const { instance, t } = scene.closest(downAt(...xs), { time, ...more });
      return [...instance].map((number, i) => (number < 0 ? null : [number, t[i]]));
    };
    assert.deepEqual(at([0, 8, 20], 0), [[0, 2], null, [1, 2]]);
    assert.deepEqual(at([0, 8, 4, 20], 1), [null, [0, 2], null, [1, 6]]);
    assert.deepEqual(at([0, 4, 20], 0.5), [null, [0, 2], [1, 4]]);
    assert.deepEqual(at([0, 4, 20], new Float32Array([0, 0.5, 0.25])), [[0, 2], [0, 2], [1, 3]]);
    assert.deepEqual(at([0, 4, 20], new Float32Array([0, 0.5, 0.25]), { filter: ({ ray }) => ray > 0 }), [null, [0, 2], [1, 3]]);
    // More rays than go over at once, each with its time; and none has the time of those before.
    const xs = Array.from({ length: 9000 }, (_, i) => 8 * (i % 2));
    const times = Float32Array.from(xs, (x) => x / 8);
    assert.ok(scene.any(downAt(...xs), { time: times }).every((hit) => hit === 1));
    assert.deepEqual([...scene.any(downAt(0, 8))], [1, 0]);
    assert.deepEqual([...scene.allHits(downAt(0, 8), { time: 1 }).starts], [0, 0, 1]);
    assert.equal(scene.closestPoint(new Float32Array([20, 0, 0]), { time: 1 }).distance[0], 4);
    slides.setTransforms([moved(50), moved(60), moved(50)]);
    scene.commit();
    assert.deepEqual(at([50, 60], 0.5), [null, [0, 2]]);
    slides.setTransform(moved(3));
    scene.commit();
    assert.deepEqual(at([3], 0.7), [[0, 2]]);
    for (const [call, type, message] of [
      [() => at([0], NaN), RangeError, "time is NaN, and should be a number from 0 to 1"],
      [() => at([0], "1"), TypeError, "time is 1, and should be a number from 0 to 1 or a Float32Array of them"],
      [() => at([0], new Float32Array(2)), RangeError, "time has 2 elements for 1 rays"],
      [() => at([0], new Float32Array([NaN])), RangeError, "time[0], of ray 0, is NaN"],
      [() => slides.setTransforms([]), TypeError, "transforms should be an array of one matrix or more"],
      [() => slides.setTransforms([moved(0), [1]]), TypeError, "transform is an Array, and should be 16 numbers, column by column"],
      [() => slides.setTransforms([moved(0), new Array(15).fill(0).concat(1)]), RangeError, "transform 1 is nearly flat: it should have an inverse"],
      [() => slides.setTransforms([moved(0), moved(1), scaled(-1, -1, 1), moved(0)]), RangeError, "halfway from transform 1 to 2 it is nearly flat: keys of a rotation should be less than half a turn apart"],
      [() => scene.addMovingMesh([]), TypeError, "keys should be an array of one Float32Array of positions or more"],
      [() => scene.addMovingMesh([layers(1), layers(2)]), RangeError, "the keys have 9 and 18 numbers, and should have as many"],
      [() => sinks.refit(layers(1)), TypeError, "this mesh has keys, and takes no positions: add a new one"],
    ]) {
      assert.throws(call, refuses(type, message));
    }
    assert.deepEqual(at([3], 0.7), [[0, 2]]);
  }
});

test("points and curves are in scenes like meshes", async () => {
  for (const simd of [false, true]) {
    const scene = await createScene({ simd });
    // Of radius 1, without a radius, of radius 2.
    const spheres = scene.addRound("spheres", new Float32Array([0, 0, 0, 1, 5, 0, 0, 0, 10, 0, 0, 2]));
    const disc = scene.addRound("discs", new Float32Array([20, 0, 1, 2, 0, 0, 3]), { quality: "fast" });
    const line = scene.addRound("linear", new Float32Array([30, 0, 0, 1, 30, 4, 0, 1]));
    const curve = scene.addRound("cubic", new Float32Array([0, 1, 2, 3].flatMap((y) => [40, y, 0, 1])));
    assert.deepEqual([spheres, disc, line, curve].map((mesh) => mesh.triangles), [2, 1, 1, 1]);
    assert.ok(spheres.bytes > 0);
    scene.insert(spheres);
    scene.insert(disc, { transform: moved(0, 0, 3) });
    scene.insert(line);
    scene.insert(curve);
    scene.commit();
    const down = (x, y) => [x, y, 8, 0, 0, 0, -1, Infinity];
    const rays = new Float32Array([down(0, 0), down(5, 0), down(10, 0), down(20, 1), down(30, 1), down(40, 1.5)].flat());
    const { t, u, triangle, instance } = scene.closest(rays);
    assert.deepEqual([...instance], [0, -1, 0, 1, 2, 3]);
    assert.deepEqual([...triangle], [0, -1, 2, 0, 0, 0]);
    assert.deepEqual([...t.subarray(0, 5)], [7, Infinity, 6, 4, 7]);
    assert.deepEqual([...u.subarray(0, 5)], [0, 0, 0, 0.5, 0.25]);
    assert.ok(Math.abs(t[5] - 7) < 0.005 && Math.abs(u[5] - 0.5) < 0.01);
    for (const [call, type, message] of [
      [() => scene.addRound("sphere", new Float32Array(4)), RangeError, 'kind is "sphere", and should be one of spheres, discs, linear, cubic'],
      [() => scene.addRound("spheres", [0, 0, 0, 1]), TypeError, "numbers is an Array, and should be a Float32Array"],
      [() => scene.addRound("discs", new Float32Array(8)), RangeError, "numbers has 8 numbers, which are not a multiple of 7"],
      [() => scene.addRound("spheres", new Float32Array([0, NaN, 0, 1])), RangeError, "numbers[1], of primitive 0, is NaN"],
      [() => spheres.refit(layers(1)), TypeError, "this mesh is of points or curves, and takes no positions: add a new one"],
    ]) {
      assert.throws(call, refuses(type, message));
    }
  }
});

test("an empty array of indices is no triangles; transforms that nearly flatten are refused, and those that flatten hide", async () => {
  const scene = await createScene();
  const none = new Uint32Array(0);
  const empty = [scene.addMesh(layers(1), none), scene.addMovingMesh([layers(1), layers(1)], none), scene.addMesh(new Float32Array(12), none)];
  assert.deepEqual(empty.map((mesh) => mesh.triangles), [0, 0, 0]);
  empty.forEach((mesh) => scene.insert(mesh));
  const instance = scene.insert(scene.addMesh(layers(1), undefined, null), null);
  const seen = () => (scene.commit(), [...scene.closest(downAt(0), null).instance]);
  assert.deepEqual(seen(), [3]);
  for (const [z, hidden] of [[1e-4, false], [1e-7, true], [0, true]]) {
    instance.setTransform(scaled(1, 1, z));
    assert.deepEqual(seen(), [hidden ? -1 : 3], `${z}`);
  }
  assert.throws(() => instance.setTransform(scaled(1, 1, 1e-5)), RangeError);
  // Anything that has a length and numbers.
  instance.setTransform({ length: 16, ...moved(0) });
  assert.deepEqual(seen(), [3]);
});

test("meshes are freed, if no instance shows them, and their memory is used again", async () => {
  for (const simd of [false, true]) {
    const scene = await createScene({ simd });
    const stays = scene.insert(scene.addMesh(layers(1, 8)));
    const mesh = scene.addMesh(layers(1));
    const instances = [scene.insert(mesh), scene.insert(mesh)];
    assert.equal(mesh.instances, 2);
    scene.commit();
    assert.throws(() => mesh.free(), refuses(TypeError, "2 instances show this mesh: remove them before it is freed, or call setMesh"));
    instances[0].remove();
    assert.throws(() => mesh.free(), refuses(TypeError, "an instance shows this mesh: remove it before it is freed, or call setMesh"));
    instances[1].setMesh(stays.mesh);
    assert.deepEqual([mesh.instances, stays.mesh.instances], [0, 2]);
    mesh.free();
    mesh.free();
    for (const call of [() => mesh.triangles, () => mesh.bytes, () => mesh.refit(layers(1)), () => scene.insert(mesh), () => stays.setMesh(mesh)]) {
      assert.throws(call, refuses(TypeError, "this mesh was freed"));
    }
    // Another mesh has its number; rays see the old one until the next commit.
    const next = scene.addMesh(layers(1, 20));
    assert.deepEqual([...scene.closest(downAt(0, 8, 20)).instance], [1, 0, -1]);
    const { number } = scene.insert(next);
    next.refit(layers(1, 24));
    scene.commit();
    assert.deepEqual([...scene.closest(downAt(0, 8, 20, 24)).instance], [-1, 0, -1, number]);
  }
});

/** A scene, and the memory of its instance. */
async function sceneWithMemory(t) {
  const { instantiate } = WebAssembly;
  let memory;
  t.mock.method(WebAssembly, "instantiate", async (module) => {
    const instance = await instantiate(module);
    memory = instance.exports.memory;
    return instance;
  });
  const scene = await createScene();
  return { scene, memory };
}

test("memory of meshes is used again after they were freed", async (t) => {
  const { scene, memory } = await sceneWithMemory(t);
  const sizes = [];
  for (let i = 0; i < 60; i++) {
    const [positions, options] = [layers(1000 + 500 * (i % 5)), { quality: "fast" }];
    const meshes = [
      scene.addMesh(positions, null, options),
      scene.addMovingMesh([positions, positions], null, options),
      scene.addRound("spheres", new Float32Array(4000).fill(1), options),
    ];
    const instances = meshes.map((mesh) => scene.insert(mesh));
    meshes[0].refit(positions);
    assert.equal(scene.commit(), 3);
    instances.forEach((instance) => instance.remove());
    meshes.forEach((mesh) => mesh.free());
    sizes.push(memory.buffer.byteLength);
  }
  assert.ok(sizes[59] <= sizes[19], `${sizes}`);
});

test("where there is no memory left, the scene stays as it was, or says that it is lost", async (t) => {
  const { scene, memory } = await sceneWithMemory(t);
  // 25 MB are left.
  memory.grow(65536 - 400 - memory.buffer.byteLength / 65536);
  scene.insert(scene.addMesh(layers(1)));
  scene.commit();
  const full = refuses(RangeError, "there is no memory left for this mesh: WebAssembly has at most 4 GiB");
  const [positions, added] = [layers(5000), []];
  for (const add of [
    () => scene.addMesh(positions),
    () => scene.addMovingMesh([positions, positions]),
    () => scene.addRound("cubic", new Float32Array(16 * 5000).fill(1)),
  ]) {
    assert.throws(() => {
      for (;;) {
        added.push(add());
      }
    }, full);
    assert.deepEqual([...scene.closest(downAt(0)).instance], [0]);
  }
  assert.ok(added.length > 20, `${added.length}`);
  added.pop().free();
  added.pop().free();
  const mesh = scene.addMesh(layers(4000));
  scene.insert(mesh);
  assert.equal(scene.commit(), 2);
  // Nobody knows beforehand how many hits there are.
  assert.throws(
    () => scene.allHits(downAt(...new Array(4000).fill(0))),
    refuses(RangeError, "there is no memory left, and this scene is lost: WebAssembly has at most 4 GiB"),
  );
  const lost = refuses(TypeError, "this scene ran out of memory and is lost");
  for (const call of [() => scene.closest(downAt(0)), () => scene.commit(), () => mesh.triangles, () => scene.addMesh(layers(1))]) {
    assert.throws(call, lost);
  }
});
