// Runs under `node --test`: the package against brute force.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { test } from "node:test";
import { runInNewContext } from "node:vm";

import { build, createScene, hasSimd } from "./index.js";

/** Numbers from 0 to 1, always the same (mulberry32). */
function generator(seed) {
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

/** Triangles thrown about a cube, without indices. */
function soup(count, seed) {
  const random = generator(seed);
  const positions = new Float32Array(9 * count);
  for (let i = 0; i < positions.length; i += 9) {
    const middle = [random(), random(), random()];
    for (let k = 0; k < 9; k++) {
      positions[i + k] = middle[k % 3] + 0.2 * (random() - 0.5);
    }
  }
  return positions;
}

/** Rays through the cube from around it. */
function raysThrough(count, seed) {
  const random = generator(seed);
  const rays = new Float32Array(8 * count);
  for (let i = 0; i < rays.length; i += 8) {
    for (let k = 0; k < 3; k++) {
      const [from, to] = [4 * random() - 1.5, random()];
      rays[i + k] = from;
      rays[i + 4 + k] = to - from;
    }
    rays[i + 7] = Infinity;
  }
  return rays;
}

/** The nearest hit of a ray, by Möller and Trumbore's test of all triangles in double precision. */
function bruteForce(positions, ray) {
  const [ox, oy, oz, tMin, dx, dy, dz, tMax] = ray;
  let best = { t: Infinity, u: 0, v: 0, triangle: -1, margin: Infinity };
  let margin = Infinity;
  for (let i = 0; i < positions.length; i += 9) {
    const p = positions.subarray(i, i + 9);
    const [ex, ey, ez] = [p[3] - p[0], p[4] - p[1], p[5] - p[2]];
    const [fx, fy, fz] = [p[6] - p[0], p[7] - p[1], p[8] - p[2]];
    const [px, py, pz] = [dy * fz - dz * fy, dz * fx - dx * fz, dx * fy - dy * fx];
    const det = ex * px + ey * py + ez * pz;
    const [sx, sy, sz] = [ox - p[0], oy - p[1], oz - p[2]];
    const u = (sx * px + sy * py + sz * pz) / det;
    const [qx, qy, qz] = [sy * ez - sz * ey, sz * ex - sx * ez, sx * ey - sy * ex];
    const v = (dx * qx + dy * qy + dz * qz) / det;
    const t = (fx * qx + fy * qy + fz * qz) / det;
    // How far the ray is from the triangle's edges: near them, rounding decides.
    margin = Math.min(margin, Math.abs(Math.min(u, v, 1 - u - v)));
    if (u >= 0 && v >= 0 && u + v <= 1 && t >= tMin && t <= tMax && t < best.t) {
      best = { t, u, v, triangle: i / 9 };
    }
  }
  return { ...best, margin };
}

for (const simd of [false, true]) {
  test(`hits are those of brute force, ${simd ? "with" : "without"} SIMD`, async () => {
    const positions = soup(300, 1);
    const rays = raysThrough(2000, 2);
    const tree = await build(positions, null, { simd });
    assert.equal(tree.simd, simd && hasSimd());
    assert.equal(tree.triangles, 300);
    const hits = tree.closest(rays);
    const occluded = tree.any(rays);
    let [compared, hit] = [0, 0];
    for (let i = 0; i < 2000; i++) {
      const expected = bruteForce(positions, rays.subarray(8 * i, 8 * i + 8));
      assert.equal(occluded[i], Number(hits.triangle[i] >= 0));
      if (expected.margin > 1e-5) {
        compared += 1;
        hit += Number(expected.triangle >= 0);
        assert.equal(hits.triangle[i], expected.triangle, `ray ${i}`);
        for (const name of ["t", "u", "v"]) {
          const error = Math.abs(hits[name][i] - expected[name]);
          assert.ok(expected[name] === hits[name][i] || error < 1e-4, `${name} of ray ${i}: ${error}`);
        }
      }
    }
    assert.ok(compared > 1800 && hit > 500 && hit < compared - 100, `${hit} of ${compared} hit`);
  });
}

test("hits are equal to the bit with and without SIMD, for every quality", async () => {
  const positions = soup(2000, 3);
  // More than a batch, and not a multiple of it.
  const rays = raysThrough(9001, 4);
  const results = [];
  for (const simd of [false, true]) {
    for (const quality of ["fast", "medium", "high"]) {
      results.push((await build(positions, null, { simd, quality })).closest(rays));
    }
  }
  for (const name of ["t", "u", "v", "triangle"]) {
    const bits = results.map((hits) => Buffer.from(hits[name].buffer));
    assert.ok(bits.every((other) => other.equals(bits[0])), name);
  }
  assert.equal(results[0].t.length, 9001);
});

const SQUARE = new Float32Array([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0]);
const SQUARE_INDICES = [0, 1, 2, 0, 2, 3];
const DOWN = new Float32Array([0.75, 0.25, 2, 0, 0, 0, -1, Infinity]);

test("indices of 16 and 32 bits, t intervals, misses", async () => {
  for (const indices of [new Uint16Array(SQUARE_INDICES), new Uint32Array(SQUARE_INDICES)]) {
    const tree = await build(SQUARE, indices);
    assert.equal(tree.triangles, 2);
    assert.ok(tree.bytes >= 256);
    const rays = new Float32Array(32);
    for (let i = 0; i < 4; i++) {
      rays.set(DOWN, 8 * i);
    }
    rays[8] = 0.25; // the other triangle
    rays[9] = 0.75;
    rays[16 + 7] = 1.5; // ends before
    rays[24 + 3] = 2.5; // begins behind
    const hits = tree.closest(rays);
    assert.deepEqual([...hits.triangle], [0, 1, -1, -1]);
    assert.deepEqual([...hits.t], [2, 2, Infinity, Infinity]);
    assert.deepEqual([hits.u[0], hits.v[0]], [0.5, 0.25]);
    assert.deepEqual([...tree.any(rays)], [1, 1, 0, 0]);
  }
});

test("no triangles, no rays, and triangles that cannot be hit", async () => {
  const empty = await build(new Float32Array(0));
  assert.deepEqual([empty.triangles, empty.closest(DOWN).triangle[0]], [0, -1]);
  assert.equal(empty.closest(new Float32Array(0)).t.length, 0);
  // An empty array of indices is no triangles; none at all is every three vertices.
  for (const none of [new Uint32Array(0), new Uint16Array(0)]) {
    const tree = await build(SQUARE.subarray(0, 9), none);
    assert.deepEqual([tree.triangles, tree.closest(DOWN).triangle[0], tree.any(DOWN)[0]], [0, -1, 0]);
    assert.equal((await build(SQUARE, none)).triangles, 0);
    assert.equal(tree.refit(SQUARE, none), 1);
  }
  for (const whole of [null, undefined]) {
    assert.equal((await build(SQUARE.subarray(0, 9), whole)).triangles, 1);
  }
  const folded = await build(SQUARE, new Uint16Array([0, 1, 1, 0, 1, 2]));
  assert.deepEqual([folded.triangles, folded.closest(DOWN).triangle[0]], [1, 1]);
});

test("answers go where they are wanted", async () => {
  const tree = await build(SQUARE, new Uint16Array(SQUARE_INDICES));
  const hits = { t: new Float32Array(1), u: new Float32Array(1), v: new Float32Array(1), triangle: new Int32Array(1) };
  assert.equal(tree.closest(DOWN, { hits }), hits);
  assert.deepEqual([hits.t[0], hits.triangle[0]], [2, 0]);
  const occluded = new Uint8Array(1);
  assert.equal(tree.any(DOWN, { occluded }), occluded);
  assert.equal(occluded[0], 1);
});

test("wrong arguments have errors that say what would be right, and leave the tree usable", async () => {
  const refuses = (type, message) => (error) => {
    assert.ok(error instanceof type && error.message === message, `${error}`);
    return true;
  };
  const building = [
    [[[1, 2, 3]], TypeError, "positions is an Array, and should be a Float32Array"],
    [[null], TypeError, "positions is null, and should be a Float32Array"],
    [[new Float64Array(9)], TypeError, "positions is a Float64Array, and should be a Float32Array"],
    [[new Float32Array(10)], RangeError, "positions has 10 numbers, which are not a multiple of 9, three vertices for each triangle"],
    [[new Float32Array(10), new Uint16Array(3)], RangeError, "positions has 10 numbers, which are not a multiple of 3, which is a vertex"],
    [[new Float32Array(9).fill(NaN, 4)], RangeError, "positions[4] is NaN, and should be between ±4398046511104"],
    [[new Float32Array(9).fill(Infinity, 8)], RangeError, "positions[8] is Infinity, and should be between ±4398046511104"],
    [[SQUARE, [0, 1, 2]], TypeError, "indices is an Array, and should be a Uint32Array or Uint16Array"],
    [[SQUARE, new Int32Array(3)], TypeError, "indices is an Int32Array, and should be a Uint32Array or Uint16Array"],
    [[SQUARE, new Uint16Array(4)], RangeError, "indices has 4 numbers, which are not a multiple of 3"],
    [[SQUARE, new Uint16Array([0, 1, 4])], RangeError, "indices[2] is 4, and there are 4 vertices"],
    [[SQUARE, new Uint16Array(3), { quality: "best" }], RangeError, 'quality is "best", and should be one of fast, medium, high'],
  ];
  for (const [args, type, message] of building) {
    await assert.rejects(build(...args), refuses(type, message));
  }

  const tree = await build(SQUARE, new Uint16Array(SQUARE_INDICES));
  const tracing = [
    [() => tree.closest([0]), TypeError, "rays is an Array, and should be a Float32Array"],
    [() => tree.closest(), TypeError, "rays is undefined, and should be a Float32Array"],
    [() => tree.closest(new Float32Array(9)), RangeError, "rays has 9 numbers, which are not a multiple of 8"],
    [() => tree.any(new Float32Array(16).fill(NaN, 11)), RangeError, "rays[11], of ray 1, is NaN"],
    [() => tree.closest(DOWN, { hits: 7 }), TypeError, "hits is 7, and should hold the arrays t, u, v and triangle"],
    [() => tree.closest(DOWN, { hits: { t: new Float32Array(1) } }), TypeError, "hits.u is undefined, and should be a Float32Array"],
    [() => tree.any(DOWN, { occluded: new Uint8Array(2) }), RangeError, "occluded has 2 elements for 1 rays"],
  ];
  for (const [call, type, message] of tracing) {
    assert.throws(call, refuses(type, message));
    assert.equal(tree.closest(DOWN).triangle[0], 0);
  }

  tree.free();
  tree.free();
  assert.throws(() => tree.closest(DOWN), refuses(TypeError, "this tree was freed"));
  assert.equal((await build(SQUARE, new Uint16Array(SQUARE_INDICES))).any(DOWN)[0], 1);
});

test("what gets past the checks is refused by the WebAssembly, which goes on", async () => {
  const files = ["halfdome.wasm", "halfdome-scene.wasm", "halfdome-simd.wasm", "halfdome-scene-simd.wasm"];
  for (const file of files.slice(0, hasSimd() ? 4 : 2)) {
    const { instance } = await WebAssembly.instantiate(await readFile(new URL(file, import.meta.url)));
    const { memory, positions, indices, rays, points, ...calls } = instance.exports;
    // The address comes first, as asking for it may move the memory.
    const put = (address, numbers) => new numbers.constructor(memory.buffer, address, numbers.length).set(numbers);
    assert.equal(positions(2 ** 30 - 1), 0, "there is no memory for 4 GiB");
    put(positions(9), SQUARE.subarray(0, 9));
    put(indices(3), new Uint32Array([0, 1, 3]));
    assert.equal(calls.add_mesh(2), -1, "vertex 3 does not exist");
    put(positions(9), SQUARE.subarray(0, 9));
    assert.equal(calls.add_mesh(3), -1, "quality 3 does not exist");
    put(positions(9), SQUARE.subarray(0, 9));
    assert.equal(calls.add_mesh(0), 0);
    put(rays(1), DOWN);
    // More rays than there are.
    const address = calls.closest(0, 1000);
    assert.equal(new Uint32Array(memory.buffer, address, 4)[3], 0);
    // Meshes and items that there are not.
    assert.equal(new Int32Array(memory.buffer, calls.closest(7, 1), 4)[3], -1);
    assert.equal(new Uint32Array(memory.buffer, calls.all_hits(-7, 1, 9), 1)[0], 0);
    points(1);
    assert.equal(new Int32Array(memory.buffer, calls.closest_points(7, 9), 4)[3], -1);
    assert.deepEqual([calls.triangles(7), calls.bytes(7), calls.refit(7)], [0, 0, -1]);
    assert.deepEqual([calls.free_mesh(7), calls.has_room(1), calls.has_room(65536), calls.has_room(-1)], [-1, 1, 0, 0]);
    assert.equal(calls.simd(), Number(file.includes("simd")));
    if (!file.includes("scene")) {
      assert.equal(calls.commit, undefined);
      continue;
    }
    const { matrices } = calls;
    put(matrices(1), new Float32Array(16).fill(NaN));
    assert.equal(calls.insert(0, -1), -1, "NaN is no place");
    put(matrices(2), new Float32Array(32).fill(NaN));
    assert.equal(calls.insert(0, -1), -1, "nor are two NaNs");
    put(matrices(1), new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]));
    assert.equal(calls.insert(7, -1), -1, "there is no mesh 7");
    assert.equal(calls.insert(0, -1), 0);
    assert.deepEqual([calls.set_transform(1), calls.set_mask(1, 1), calls.set_mesh(1, 0), calls.set_mesh(0, 1), calls.remove(1)], [-1, -1, -1, -1, -1]);
    assert.equal(calls.commit(), 1);
    assert.equal(new Int32Array(memory.buffer, calls.scene_closest(1, -1), 5)[4], 0);
    assert.equal(calls.add_moving_mesh(2), -1, "there is no key");
    put(positions(9), SQUARE.subarray(0, 9));
    put(indices(3), new Uint32Array([0, 1, 3]));
    assert.equal(calls.add_key(), -1, "vertex 3 does not exist");
    for (const corners of [9, 18]) {
      put(positions(corners), new Float32Array(corners));
      assert.equal(calls.add_key(), 0);
    }
    assert.equal(calls.add_moving_mesh(2), -1, "keys differ in length");
    put(positions(9), SQUARE.subarray(0, 9));
    calls.add_key();
    assert.equal(calls.add_moving_mesh(3), -1, "quality 3 does not exist");
    put(positions(18), new Float32Array(18));
    calls.add_key();
    calls.forget_keys();
    put(positions(9), SQUARE.subarray(0, 9));
    calls.add_key();
    assert.equal(calls.add_moving_mesh(2), 1);
    assert.equal(calls.refit(1), -1, "it has keys");
    assert.equal(new Int32Array(memory.buffer, calls.closest(1, 1), 4)[3], -1, "only scenes trace it");
    // Times of fewer rays than there are.
    put(matrices(1), new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]));
    calls.insert(1, -1);
    calls.times(0);
    assert.equal(calls.commit(), 2);
    assert.equal(new Int32Array(memory.buffer, calls.scene_closest(1, -1), 5)[4], 0);
    // Meshes that were freed, while items have them.
    assert.deepEqual([calls.free_mesh(0), calls.free_mesh(0), calls.triangles(0), calls.set_mesh(1, 0), calls.insert(0, -1)], [0, -1, 0, -1, -1]);
    assert.equal(calls.commit(), 2);
    assert.equal(new Int32Array(memory.buffer, calls.scene_closest(1, -1), 5)[4], 0);
  }
});

test("arrays that a tree was built from may change", async () => {
  const positions = SQUARE.slice();
  const tree = await build(positions, new Uint16Array(SQUARE_INDICES));
  positions.fill(9);
  assert.equal(tree.closest(DOWN).triangle[0], 0);
});

test("arrays may change or go while the module is loaded", async () => {
  const [positions, indices] = [SQUARE.slice(), new Uint16Array(SQUARE_INDICES)];
  const building = build(positions, indices);
  positions.fill(9);
  indices.fill(60000);
  structuredClone(positions.buffer, { transfer: [positions.buffer] });
  const tree = await building;
  assert.deepEqual([tree.triangles, tree.closest(DOWN).triangle[0]], [2, 0]);
  const detached = /^TypeError: (positions|rays) has a buffer that is detached, as it was transferred: it has no numbers any more$/;
  await assert.rejects(build(positions), detached);
  assert.throws(() => tree.closest(positions), detached);
});

test("typed arrays of other realms, and options that are null", async () => {
  const other = (code) => runInNewContext(code);
  const tree = await build(other(`new Float32Array([${SQUARE}])`), other(`new Uint16Array([${SQUARE_INDICES}])`), null);
  const hits = other("({ t: new Float32Array(1), u: new Float32Array(1), v: new Float32Array(1), triangle: new Int32Array(1) })");
  const rays = other("new Float32Array([0.75, 0.25, 2, 0, 0, 0, -1, Infinity])");
  assert.equal(tree.closest(rays, { hits }).triangle[0], 0);
  assert.deepEqual([tree.closest(DOWN, null).triangle[0], tree.any(DOWN, null)[0], tree.allHits(DOWN, null).t[0]], [0, 1, 2]);
  assert.equal(tree.closestPoint(new Float32Array(3), null).triangle[0], 0);
});

test("the WebAssembly may be handed over", async () => {
  const url = new URL("halfdome.wasm", import.meta.url);
  const bytes = await readFile(url);
  const module = await WebAssembly.compile(bytes);
  const arrayBuffer = new Uint8Array(bytes).buffer;
  for (const wasm of [url, url.href, bytes, arrayBuffer, module, Promise.resolve(module), new Response(bytes)]) {
    const tree = await build(SQUARE, new Uint16Array(SQUARE_INDICES), { wasm });
    assert.deepEqual([tree.simd, tree.closest(DOWN).triangle[0]], [false, 0]);
  }
  const empty = await WebAssembly.compile(new Uint8Array([0, 97, 115, 109, 1, 0, 0, 0]));
  for (const [wasm, type, message] of [
    [7, TypeError, "wasm is 7, and should be a URL, a Response, an ArrayBuffer, a Uint8Array or a WebAssembly.Module"],
    [[], TypeError, "wasm is an Array, and should be a URL, a Response, an ArrayBuffer, a Uint8Array or a WebAssembly.Module"],
    [empty, TypeError, "wasm should be one of the .wasm files of this version of the package"],
    [new Response("", { status: 404, statusText: "Gone" }), Error, ": 404 Gone: its .wasm file should be there, or be handed over as the option `wasm`"],
  ]) {
    await assert.rejects(build(SQUARE, new Uint16Array(SQUARE_INDICES), { wasm }), (error) => error instanceof type && error.message === message);
  }
  const trees = { wasm: module };
  await assert.rejects(createScene(trees), /^TypeError: wasm has trees alone: scenes need halfdome-scene.wasm or halfdome-scene-simd.wasm$/);
  const scene = await createScene({ wasm: await readFile(new URL("halfdome-scene.wasm", import.meta.url)) });
  assert.deepEqual([scene.simd, scene.commit()], [false, 0]);
});
