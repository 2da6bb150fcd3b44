// Runs under `node --test`: what three.js has, beside three.js's own raycaster.
import assert from "node:assert/strict";
import { test } from "node:test";

import * as THREE from "three";

import { build, createScene } from "./index.js";
import { insertObject, meshOf, raysOf } from "./three.js";

/** Rays from all around to near the middle. */
function raysAround(count, radius) {
  return Array.from({ length: count }, (_, i) => {
    const [a, z] = [2.4 * i, 2 * ((i * 0.618034) % 1) - 1];
    const origin = new THREE.Vector3(Math.cos(a), Math.sin(a), z).multiplyScalar(radius);
    const target = new THREE.Vector3(Math.sin(3 * i), Math.cos(5 * i), Math.sin(7 * i)).multiplyScalar(0.4 * radius);
    return new THREE.Ray(origin, target.sub(origin).normalize());
  });
}

/** The nearest hit by three.js. */
function byThree(root, ray) {
  const caster = new THREE.Raycaster(ray.origin, ray.direction);
  return caster.intersectObject(root, true)[0];
}

test("geometries of all layouts are the same mesh", async () => {
  const plain = new THREE.TorusKnotGeometry(1, 0.3, 60, 8);
  const interleaved = plain.clone();
  const [count, position] = [plain.attributes.position.count, plain.attributes.position];
  const buffer = new THREE.InterleavedBuffer(new Float32Array(7 * count), 7);
  interleaved.setAttribute("position", new THREE.InterleavedBufferAttribute(buffer, 3, 2));
  for (let i = 0; i < count; i++) {
    interleaved.attributes.position.setXYZ(i, position.getX(i), position.getY(i), position.getZ(i));
  }
  const bytes = plain.clone();
  bytes.setIndex(new THREE.BufferAttribute(new Uint32Array(plain.index.array), 1));
  const loose = plain.toNonIndexed();
  const rays = raysOf(raysAround(500, 3));
  const expected = (await build(position.array, plain.index.array)).closest(rays);
  assert.ok(expected.triangle.filter((triangle) => triangle >= 0).length > 100);
  for (const geometry of [plain, interleaved, bytes, loose]) {
    const { positions, indices } = meshOf(geometry);
    assert.deepEqual((await build(positions, indices)).closest(rays), expected);
  }
  assert.equal(meshOf(plain).positions, position.array);
  assert.throws(() => meshOf({}), TypeError);

  // Normalised to 16 bits, and with two vertices too many.
  const corners = new THREE.BufferGeometry();
  const numbers = new Int16Array([0, 0, 0, 32767, 0, 0, 0, 32767, 0, 1, 1, 1, 2, 2, 2]);
  corners.setAttribute("position", new THREE.BufferAttribute(numbers, 3, true));
  assert.deepEqual([...meshOf(corners).positions], [0, 0, 0, 1, 0, 0, 0, 1, 0]);
});

test("objects are hit where three.js hits them, while they move", async () => {
  const root = new THREE.Group();
  const geometry = new THREE.IcosahedronGeometry(0.6, 2);
  const material = new THREE.MeshBasicMaterial({ side: THREE.DoubleSide });
  for (let i = 0; i < 6; i++) {
    root.add(new THREE.Mesh(i % 2 ? geometry : new THREE.BoxGeometry(1, 1.5, 0.7), material));
  }
  const crowd = new THREE.InstancedMesh(geometry, material, 5);
  const parent = new THREE.Group();
  parent.add(crowd);
  root.add(parent);
  const place = (frame) => {
    root.children.slice(0, 6).forEach((mesh, i) => {
      mesh.position.set(3 * Math.cos(i + 0.3 * frame), 3 * Math.sin(i + 0.3 * frame), 0.5 * i - 1);
      mesh.rotation.set(frame, i, 0);
      mesh.scale.setScalar(1 + 0.2 * frame);
    });
    parent.rotation.z = 0.5 * frame;
    for (let i = 0; i < 5; i++) {
      crowd.setMatrixAt(i, new THREE.Matrix4().makeTranslation(i - 2.5, 0.2 * i, -1));
    }
    crowd.boundingSphere = null;
    root.updateMatrixWorld(true);
  };
  place(0);
  const scene = await createScene();
  const world = insertObject(scene, root);
  assert.equal(world.entries.length, 11);
  for (let frame = 0; frame < 3; frame++) {
    place(frame);
    world.update();
    assert.equal(scene.commit(), 11);
    const rays = raysAround(300, 6);
    const { t, triangle, instance } = scene.closest(raysOf(rays));
    let [hits, same] = [0, 0];
    rays.forEach((ray, i) => {
      const expected = byThree(root, ray);
      if (expected === undefined || triangle[i] < 0) {
        return;
      }
      hits += 1;
      const { object, index } = world.objectOf(instance[i]);
      const isSame = object === expected.object && index === (expected.instanceId ?? 0) && triangle[i] === expected.faceIndex;
      same += Number(isSame && Math.abs(t[i] - expected.distance) < 1e-4);
    });
    const missed = rays.filter((ray, i) => (byThree(root, ray) === undefined) !== triangle[i] < 0).length;
    // Rays along edges may go to either side.
    assert.ok(hits > 60 && same >= 0.99 * hits && missed <= 2, `${same} of ${hits}, ${missed} others`);
  }
  world.remove();
  assert.equal(scene.commit(), 0);
});

/** All hits along a ray down at x and y: where, of which face, and of which of an object's own instances. */
const downAt = (x, y) => new THREE.Ray(new THREE.Vector3(x, y, 10), new THREE.Vector3(0, 0, -1));

/** Compares all hits with three.js's. */
function compare(scene, world, root, places) {
  root.updateMatrixWorld(true);
  let count = 0;
  for (const [x, y] of places) {
    const ray = downAt(x, y);
    const expected = new THREE.Raycaster(ray.origin, ray.direction).intersectObject(root, true);
    const { t, triangle, instance } = scene.allHits(raysOf([ray]));
    const found = [...t].map((t, i) => {
      const { object, index, firstTriangle } = world.objectOf(instance[i]);
      return [t, object.id, index, firstTriangle + triangle[i]];
    });
    assert.deepEqual(
      found,
      expected.map(({ distance, object, batchId, instanceId, faceIndex }) => [distance, object.id, batchId ?? instanceId ?? 0, faceIndex]),
      `at ${x}, ${y}`,
    );
    count += found.length;
  }
  return count;
}

const MATERIAL = new THREE.MeshBasicMaterial({ side: THREE.DoubleSide });

test("ranges that are drawn, and no indices", async () => {
  const plane = () => new THREE.PlaneGeometry(2, 2, 2, 1);
  const places = [[-0.75, 0.3], [-0.25, -0.3], [0.25, 0.3], [0.75, -0.3]];
  for (const [start, count, hits] of [[0, Infinity, 4], [0, 0, 0], [0, 3, 1], [0, 6, 2], [3, 3, 1], [6, Infinity, 2], [12, 3, 0], [99, 3, 0]]) {
    for (const geometry of [plane(), plane().toNonIndexed()]) {
      geometry.setDrawRange(start, count);
      const scene = await createScene();
      const mesh = new THREE.Mesh(geometry, MATERIAL);
      const world = insertObject(scene, mesh);
      scene.commit();
      assert.equal(compare(scene, world, mesh, places), hits, `${start}, ${count}`);
    }
  }
  const geometry = plane().setIndex([]);
  assert.equal(meshOf(geometry).indices.length, 0);
  const scene = await createScene();
  insertObject(scene, new THREE.Mesh(geometry, MATERIAL));
  assert.equal(scene.commit(), 0);
});

test("instances come and go, those of a BatchedMesh too", async () => {
  const root = new THREE.Group();
  root.position.x = 0.125;
  const crowd = new THREE.InstancedMesh(new THREE.PlaneGeometry(1, 1), MATERIAL, 4);
  const batch = new THREE.BatchedMesh(8, 100, 100, MATERIAL);
  batch.frustumCulled = false;
  root.add(crowd, batch);
  for (let i = 0; i < 4; i++) {
    crowd.setMatrixAt(i, new THREE.Matrix4().makeTranslation(2 * i, 0, 0));
  }
  const [square, box] = [new THREE.PlaneGeometry(1, 1), new THREE.BoxGeometry(1, 1, 1)].map((geometry) => batch.addGeometry(geometry));
  const own = [square, box, box].map((geometry) => batch.addInstance(geometry));
  own.forEach((id, i) => batch.setMatrixAt(id, new THREE.Matrix4().makeTranslation(2 * i, 0, 2)));
  const scene = await createScene();
  const world = insertObject(scene, root);
  const places = [0, 1, 2, 3].map((i) => [2 * i + 0.25, 0.0625]);
  const count = () => {
    crowd.boundingSphere = null;
    scene.commit();
    return compare(scene, world, root, places);
  };
  assert.equal(count(), 4 + 1 + 2 + 2);
  crowd.count = 2;
  batch.setVisibleAt(own[2], false);
  world.update();
  assert.deepEqual([count(), world.entries.length], [2 + 1 + 2, 4]);
  crowd.count = 3;
  batch.deleteInstance(own[0]);
  batch.setVisibleAt(own[2], true);
  batch.setGeometryIdAt(own[1], square);
  world.update();
  assert.equal(count(), 3 + 1 + 2);
  world.remove();
  world.remove();
  assert.deepEqual([scene.commit(), world.entries.length], [0, 0]);
});

test("what bones move is left out with a warning", async (t) => {
  const warn = t.mock.method(console, "warn", () => {});
  const root = new THREE.Group();
  const skinned = new THREE.SkinnedMesh(new THREE.PlaneGeometry(1, 1), MATERIAL);
  root.add(skinned, new THREE.Mesh(new THREE.PlaneGeometry(1, 1), MATERIAL));
  const scene = await createScene();
  const world = insertObject(scene, root);
  assert.deepEqual([scene.commit(), world.skipped], [1, [skinned]]);
  const message = "halfdome leaves out objects, as it does not know where their triangles are: 1 of SkinnedMesh";
  assert.deepEqual(warn.mock.calls.map((call) => call.arguments), [[message]]);
});

test("an object that is refused leaves nothing in the scene, and neither does one that is removed", async () => {
  const scene = await createScene();
  const root = new THREE.Group();
  const flat = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), MATERIAL);
  root.add(new THREE.Mesh(new THREE.PlaneGeometry(1, 1), MATERIAL), flat);
  flat.name = "floor";
  flat.scale.z = 1e-5;
  const message = 'Mesh "floor": the transform is nearly flat: it should have an inverse, or scale by exactly 0, which hides';
  assert.throws(() => insertObject(scene, root), (error) => error instanceof RangeError && error.message === message);
  assert.equal(scene.commit(), 0);
  flat.scale.z = 1;
  // Meshes that somebody else shows stay.
  const world = insertObject(scene, root, null);
  const [first, second] = world.entries.map(({ instance }) => instance.mesh);
  const own = scene.insert(first);
  world.entries[1].instance.remove();
  world.remove();
  assert.deepEqual([scene.commit(), first.triangles, own.mesh], [1, 2, first]);
  assert.throws(() => second.triangles, /^TypeError: this mesh was freed$/);
});
