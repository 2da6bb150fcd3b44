import type { Instance, Scene } from "./index.js";

/** What is used of three.js's BufferGeometry, Ray and Object3D: any version will do. */
export interface Geometry {
  attributes: Record<string, unknown>;
  index: unknown;
  drawRange?: { start: number; count: number };
}
export interface RayLike {
  origin: { x: number; y: number; z: number };
  direction: { x: number; y: number; z: number };
}
export interface Object3D {
  traverse(visit: (object: any) => void): void;
  updateWorldMatrix(parents: boolean, children: boolean): void;
}

/**
 * The positions and indices of a BufferGeometry: its own arrays where they suit, else copies. What lies outside of `drawRange` is
 * left out, and the numbers of triangles are those that three.js calls `faceIndex`. Morph targets do not count.
 * @throws TypeError if it has no attribute `position`
 */
export function meshOf(geometry: Geometry): { positions: Float32Array; indices: Uint32Array | Uint16Array | null };

/** Rays in one array, as trees and scenes trace them. */
export function raysOf(rays: RayLike[], near?: number, far?: number): Float32Array;

export interface Entry {
  instance: Instance;
  object: any;
  /** The index in an InstancedMesh or BatchedMesh (its `batchId`); else 0. */
  index: number;
  /** What to add to a hit's `triangle` for the `faceIndex` of three.js: the first triangle of a BatchedMesh's geometry; else 0. */
  firstTriangle: number;
}

/**
 * Inserts all meshes below an object into a scene, at their places in the world: those of InstancedMesh, and those of BatchedMesh
 * that are visible, too. A geometry that several have is there once, as it is now. What bones move (SkinnedMesh) is left out with a
 * warning on the console, and so is a BatchedMesh without `getGeometryRangeAt`, of an older three.js.
 * @throws what Scene.addMesh and Scene.insert throw, with the object's name in front; the scene is then as before
 */
export function insertObject(
  scene: Scene,
  root: Object3D,
  options?: { quality?: "fast" | "medium" | "high"; mask?: number } | null,
): {
  /** All that there are now. */
  readonly entries: Entry[];
  /** Objects that were left out. */
  readonly skipped: any[];
  /** Whose the instance of a hit is. */
  objectOf(number: number): Entry | undefined;
  /**
   * Moves everything to where it is now, from the next commit on, with the instances of InstancedMesh and BatchedMesh that came and
   * without those that went. Not with objects that came below the root, nor with geometries that changed.
   */
  update(): void;
  /** Removes everything, from the next commit on, and frees the meshes that no instance of somebody else's shows. */
  remove(): void;
};
