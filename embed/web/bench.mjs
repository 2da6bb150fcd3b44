// The npm package beside three-mesh-bvh: the same mesh, the same rays, one thread, in turn.
//
//     ./build.sh && ./test.sh && node bench.mjs
//
// Millions of rays a second, the best of some rounds. The mesh is a bumpy knot; camera rays look at it, diffuse rays leave
// where those hit, by the cosine. three-mesh-bvh gets its best tree (SAH) and its quickest question (`raycastFirst`, which
// also makes an object of every hit).

import { BufferAttribute, BufferGeometry, DoubleSide, Ray, TorusKnotGeometry, Vector3 } from "three";
import { MeshBVH, SAH } from "three-mesh-bvh";

import { build, hasSimd } from "./npm/index.js";

const ROUNDS = 5;
const SIDE = 256;

const knot = new TorusKnotGeometry(1, 0.35, 600, 100);
const positions = knot.attributes.position.array.slice();
for (let i = 0; i < positions.length; i += 3) {
  const [x, y, z] = positions.subarray(i, i + 3);
  const swelling = 1 + 0.02 * Math.sin(31 * x) * Math.sin(29 * y) * Math.sin(37 * z);
  positions.set([x * swelling, y * swelling, z * swelling], i);
}
const indices = Uint32Array.from(knot.index.array);

const cameraRays = new Float32Array(8 * SIDE * SIDE);
for (let i = 0; i < SIDE * SIDE; i++) {
  const [x, y] = [((i % SIDE) + 0.5) / SIDE - 0.5, 0.5 - (Math.floor(i / SIDE) + 0.5) / SIDE];
  const direction = new Vector3(x, y, -1).normalize();
  cameraRays.set([0, 0, 4, 0, ...direction, Infinity], 8 * i);
}

const trees = [["plain", await build(positions, indices, { simd: false })]];
if (hasSimd()) {
  trees.push(["SIMD", await build(positions, indices)]);
}
const diffuseRays = diffuse(trees[0][1].closest(cameraRays));
const geometry = new BufferGeometry();
geometry.setAttribute("position", new BufferAttribute(positions, 3));
// A copy, as the tree sorts it.
geometry.setIndex(new BufferAttribute(indices.slice(), 1));
const peer = new MeshBVH(geometry, { strategy: SAH });

console.log(`${indices.length / 3} triangles; millions of rays a second, and times as fast as three-mesh-bvh\n`);
for (const [name, rays] of [["camera", cameraRays], ["diffuse", diffuseRays]]) {
  compare(rays);
  const contenders = [
    ["three-mesh-bvh", () => askPeer(rays)],
    ...trees.map(([build, tree]) => [`halfdome, ${build}`, () => tree.closest(rays)]),
    ...trees.map(([build, tree]) => [`halfdome, ${build}, any hit`, () => tree.any(rays)]),
  ];
  const best = contenders.map(() => 0);
  for (let round = 0; round < ROUNDS; round++) {
    contenders.forEach(([, run], i) => {
      const start = performance.now();
      run();
      best[i] = Math.max(best[i], rays.length / 8 / 1e3 / (performance.now() - start));
    });
  }
  console.log(`${name} rays: ${rays.length / 8}`);
  contenders.forEach(([contender], i) => {
    console.log(`  ${contender.padEnd(28)} ${best[i].toFixed(2).padStart(6)} ${(best[i] / best[0]).toFixed(1).padStart(6)}×`);
  });
}

/** Rays from where others hit, with directions by the cosine from a low-discrepancy sequence. */
function diffuse(hits) {
  const rays = [];
  for (let i = 0; i < hits.t.length; i++) {
    if (hits.triangle[i] < 0) {
      continue;
    }
    const [a, b, c] = [0, 1, 2].map((k) => new Vector3().fromArray(positions, 3 * indices[3 * hits.triangle[i] + k]));
    const direction = new Vector3().fromArray(cameraRays, 8 * i + 4);
    const normal = b.clone().sub(a).cross(c.clone().sub(a)).normalize();
    normal.multiplyScalar(normal.dot(direction) > 0 ? -1 : 1);
    const [u, v] = [(0.7548776662 * i) % 1, (0.5698402909 * i) % 1];
    const [r, phi] = [Math.sqrt(u), 2 * Math.PI * v];
    const tangent = new Vector3(...(Math.abs(normal.x) < 0.9 ? [1, 0, 0] : [0, 1, 0])).cross(normal).normalize();
    const out = normal.clone().multiplyScalar(Math.sqrt(1 - u));
    out.addScaledVector(tangent, r * Math.cos(phi)).addScaledVector(normal.clone().cross(tangent), r * Math.sin(phi));
    const origin = new Vector3(0, 0, 4).addScaledVector(direction, hits.t[i]).addScaledVector(normal, 1e-4);
    rays.push(...origin, 0, ...out.normalize(), Infinity);
  }
  return Float32Array.from(rays);
}

/** The peer's distances. */
function askPeer(rays) {
  const distances = new Float32Array(rays.length / 8);
  const ray = new Ray();
  for (let i = 0; i < distances.length; i++) {
    ray.origin.fromArray(rays, 8 * i);
    ray.direction.fromArray(rays, 8 * i + 4);
    distances[i] = peer.raycastFirst(ray, DoubleSide)?.distance ?? Infinity;
  }
  return distances;
}

/** Asserts that both see the same: all but the few rays that pass by an edge. */
function compare(rays) {
  const [theirs, ours] = [askPeer(rays), trees.at(-1)[1].closest(rays).t];
  const different = theirs.filter((t, i) => t !== ours[i] && !(Math.abs(t - ours[i]) < 1e-4)).length;
  if (different > theirs.length / 1000) {
    throw new Error(`${different} of ${theirs.length} rays differ`);
  }
}
