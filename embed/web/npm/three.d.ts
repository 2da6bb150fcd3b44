import type { Instance, Scene } from "./index.js";

/** What is used of three.js's BufferGeometry, Ray and Object3D: any version will do. */
export interface Geometry {
  attributes: Record<string, unknown>;
  index: unknown;
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
 * The positions and indices of a BufferGeometry: its own arrays where they suit, else copies. Morph targets do not count.
 * @throws TypeError if it has no attribute `position`
 */
export function meshOf(geometry: Geometry): { positions: Float32Array; indices: Uint32Array | Uint16Array | null };

/** Rays in one array, as trees and scenes trace them. */
export function raysOf(rays: RayLike[], near?: number, far?: number): Float32Array;

export interface Entry {
  instance: Instance;
  object: any;
  /** The index in an InstancedMesh; else 0. */
  index: number;
}

/**
 * Inserts all meshes below an object into a scene, InstancedMesh too, at their places in the world. A geometry that several have
 * is there once.
 */
export function insertObject(
  scene: Scene,
  root: Object3D,
  options?: { quality?: "fast" | "medium" | "high"; mask?: number },
): {
  entries: Entry[];
  /** Whose the instance of a hit is. */
  objectOf(number: number): Entry | undefined;
  /** Moves everything to where it is now, from the next commit on. */
  update(): void;
  /** Removes everything, from the next commit on. */
  remove(): void;
};
