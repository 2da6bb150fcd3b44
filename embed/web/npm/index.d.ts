/** What a ray is in a Float32Array: origin x, y, z, least t, direction x, y, z, greatest t. */
export const RAY_FLOATS: 8;

/** Arrays that the package makes. Their buffers are their own, which TypeScript can say from 5.7 on. */
export type Floats = ReturnType<Float32ArrayConstructor["of"]>;
export type Integers = ReturnType<Int32ArrayConstructor["of"]>;
export type Naturals = ReturnType<Uint32ArrayConstructor["of"]>;
export type Bytes = ReturnType<Uint8ArrayConstructor["of"]>;

/** null and undefined: every three vertices are a triangle. An empty array: there are no triangles. */
export type Indices = Uint32Array | Uint16Array | null;

export interface MeshOptions {
  /** How much time to spend on a tree that is quick to trace; "high" unless told otherwise. */
  quality?: "fast" | "medium" | "high";
}

export interface EngineOptions {
  /** false: the build without SIMD, even where there is SIMD. Hits are the same to the bit. */
  simd?: boolean;
  /**
   * Where the WebAssembly comes from, or a promise of it; then `simd` does not count. Without it, the file is fetched from beside
   * index.js. Trees want halfdome.wasm or halfdome-simd.wasm, scenes halfdome-scene.wasm or halfdome-scene-simd.wasm (which will do
   * for trees); which of them runs here hasSimd() says. A WebAssembly.Module or a URL is compiled once, bytes each time.
   */
  wasm?: WasmSource | PromiseLike<WasmSource> | null;
}

/** An address (a string or a URL), a Response of fetch(), bytes (an ArrayBuffer or a Uint8Array), or a WebAssembly.Module. */
export type WasmSource = string | object;

export interface BuildOptions extends MeshOptions, EngineOptions {}

/** Where the nearest hits of a batch go, one element for each ray. */
export interface HitArrays {
  /** Distance in lengths of the ray's direction; Infinity where nothing is hit. */
  t: Float32Array;
  /** Barycentric weight of the triangle's second corner; 0 where nothing is hit. */
  u: Float32Array;
  /** Barycentric weight of the triangle's third corner; 0 where nothing is hit. */
  v: Float32Array;
  /** Number of the triangle, or -1 where nothing is hit. Of equally near ones the lowest. */
  triangle: Int32Array;
}

/** HitArrays that the package makes. */
export interface Hits extends HitArrays {
  t: Floats;
  u: Floats;
  v: Floats;
  triangle: Integers;
}

/** One hit, as a filter sees it. */
export interface Hit {
  /** Number of the ray in the batch. */
  ray: number;
  t: number;
  u: number;
  v: number;
  triangle: number;
}

export interface SceneHit extends Hit {
  instance: number;
}

/** Says whether a ray ends at a hit; if not it goes on, as through the holes of a texture. Sees a ray's hits nearest first. */
export type Filter<H> = (hit: H) => boolean;

export interface SceneHitArrays extends HitArrays {
  /** Number of the instance, or -1 where nothing is hit; of equally near ones the lowest. Scene.instance says which it is. */
  instance: Int32Array;
}

/** SceneHitArrays that the package makes. */
export interface SceneHits extends Hits {
  instance: Integers;
}

/** All hits of a batch: those of ray i are the elements from starts[i] to starts[i + 1], nearest first. */
export interface AllHits extends Hits {
  /** One element more than there are rays; the last is the number of all hits. */
  starts: Naturals;
}

export interface AllSceneHits extends AllHits, SceneHits {}

/** The points of the surface that are closest to points, one element for each. */
export interface ClosestPoints {
  /** x, y, z of each; NaN where there is none. */
  position: Floats;
  /** How far it is; Infinity where there is none. */
  distance: Floats;
  u: Floats;
  v: Floats;
  /** -1 where there is none. */
  triangle: Integers;
}

export interface ClosestScenePoints extends ClosestPoints {
  instance: Integers;
}

/** A tree over a mesh. It stays as it is, whatever happens to the arrays that it was built from. */
export interface Tree {
  /** Triangles that rays can hit: those with two equal corners are left out. */
  readonly triangles: number;
  /** Bytes that the tree takes. */
  readonly bytes: number;
  /** Whether it is traced with SIMD. */
  readonly simd: boolean;

  /**
   * The nearest hit of each ray that `filter` accepts, if there is one, written into `hits` if they are given.
   * @param rays 8 numbers for each ray, see RAY_FLOATS. Directions need no unit length; one of length 0 hits nothing.
   * @throws TypeError if an argument is of the wrong type, or after free()
   * @throws RangeError if a length is wrong, or a number of a ray is NaN
   */
  closest<H extends HitArrays>(rays: Float32Array, options: { hits: H; filter?: Filter<Hit> }): H;
  closest(rays: Float32Array, options?: { hits?: Hits; filter?: Filter<Hit> } | null): Hits;

  /**
   * Whether each ray hits anything, 1 or 0: quicker than closest().
   * @throws as closest() does
   */
  any<B extends Uint8Array>(rays: Float32Array, options: { occluded: B; filter?: Filter<Hit> }): B;
  any(rays: Float32Array, options?: { occluded?: Bytes; filter?: Filter<Hit> } | null): Bytes;

  /**
   * All hits of each ray, or the nearest `most`.
   * @throws as closest() does, and RangeError if there is no memory left for them
   */
  allHits(rays: Float32Array, options?: { most?: number } | null): AllHits;

  /**
   * The point of the triangles that is closest to each point, if it is not farther than `radius`.
   * @param points x, y, z of each
   * @throws as closest() does
   */
  closestPoint(points: Float32Array, options?: { radius?: number } | null): ClosestPoints;

  /**
   * Moves the tree to where its triangles are now: quicker than build(). Gives the cost of rays as a multiple of what it was when
   * the tree was built: from 1.5 on a new tree pays.
   * @param positions of the same triangles, in the same order
   * @throws RangeError if others can be hit than those in the tree, as where two corners became one; it is then as it was
   */
  refit(positions: Float32Array, indices?: Indices): number;

  /** Gives the memory back; without it that happens when nothing refers to the tree any more. */
  free(): void;
}

/**
 * Builds a tree. The arrays may change as soon as the call returns.
 * @param positions x, y, z of each vertex, finite and not beyond ±2^42
 * @param indices three vertices for each triangle; without them, every three vertices are one; empty, there are no triangles
 * @throws TypeError if an argument is of the wrong type, or its buffer is detached
 * @throws RangeError if a length or a number is wrong, or there is no memory left
 */
export function build(
  positions: Float32Array,
  indices?: Indices,
  options?: BuildOptions | null,
): Promise<Tree>;

/** 16 numbers, column by column, the last row 0, 0, 0, 1: as `matrixWorld.elements` of three.js. */
export type Matrix = ArrayLike<number>;

/** Triangles, points or curves that a scene has once, however many instances show them. */
export interface Mesh {
  /** How many of them rays can hit. */
  readonly triangles: number;
  readonly bytes: number;
  /** How many instances show it. */
  readonly instances: number;
  /** As of a tree; rays see it from the next commit on, in all instances. Not of a mesh with keys, nor of points or curves. */
  refit(positions: Float32Array, indices?: Indices): number;
  /**
   * Gives the memory back, at the next commit if rays see it until then. Calls after that throw a TypeError; free() does nothing.
   * @throws TypeError if instances show it
   */
  free(): void;
}

/** A mesh at a place in a scene. Changes are seen from the next commit on. */
export interface Instance {
  /** What hits call it. It is used again after the instance was removed. */
  readonly number: number;
  readonly mesh: Mesh;
  /**
   * A matrix whose determinant is 0 in single precision hides the instance, as a scale by 0 does.
   * @throws RangeError if an element is not finite, or the matrix is so nearly flat that its inverse is noise: one that scales one
   * axis by less than some 1/65,536 of another
   */
  setTransform(matrix: Matrix): void;
  /**
   * Where it is at times evenly spaced from 0 to 1; between these the numbers are interpolated, so that points move in straight
   * lines. Keys of a rotation should be less than half a turn apart, and an eighth of a turn for it to look like one.
   * @throws RangeError as setTransform does, and if a matrix, or one between two, is flat or nearly so: two or more never hide
   */
  setTransforms(matrices: readonly Matrix[]): void;
  /** Rays see it whose mask has a bit in common; 0 hides it. */
  setMask(mask: number): void;
  setMesh(mesh: Mesh): void;
  /** @throws TypeError, as all of these, if it was removed already */
  remove(): void;
}

/** What the rays of a batch see. */
export interface SceneRays {
  /** The instances whose mask has a bit in common. */
  mask?: number;
  /** When, from 0 to 1 (0): one time for all rays, or one for each. */
  time?: number | Float32Array;
  filter?: Filter<SceneHit>;
}

/** Meshes at many places that move. Rays see the scene as of its last commit. */
export interface Scene {
  readonly simd: boolean;
  /**
   * Takes memory until its free().
   * @throws as build() does. Where there is no memory left, the scene stays as it was, unless the message says that it is lost:
   * then all its methods throw a TypeError.
   */
  addMesh(positions: Float32Array, indices?: Indices, options?: MeshOptions | null): Mesh;
  /** A mesh that changes its shape: positions at times evenly spaced from 0 to 1, between which vertices move in lines. */
  addMovingMesh(keys: readonly Float32Array[], indices?: Indices, options?: MeshOptions | null): Mesh;
  /**
   * Points or curves, of so many numbers each: spheres (4: centre, radius), discs (7: centre, radius, normal of any length but 0),
   * spheres swept along segments ("linear", 8: centre and radius of both ends) or along Bézier curves ("cubic", 16: four control
   * points with a radius each). Those without a radius are left out. In hits `triangle` is the number of the primitive, `u` where
   * along a curve it is, 0 to 1, or a disc's distance from the centre in radii, and `v` 0.
   */
  addRound(kind: "spheres" | "discs" | "linear" | "cubic", numbers: Float32Array, options?: MeshOptions | null): Mesh;
  /**
   * Adds an instance: where its own coordinates say, and for all rays to see, unless told otherwise. `transforms` in place of
   * `transform`: see setTransforms.
   */
  insert(mesh: Mesh, options?: { transform?: Matrix; transforms?: readonly Matrix[]; mask?: number } | null): Instance;
  /** The instance of this number; undefined if it was removed. */
  instance(number: number): Instance | undefined;
  /** Makes all changes since the last commit. Gives the number of instances that rays can see if their masks allow. */
  commit(): number;

  /** As of a tree. What rays see: see SceneRays. */
  closest<H extends SceneHitArrays>(rays: Float32Array, options: { hits: H } & SceneRays): H;
  closest(rays: Float32Array, options?: ({ hits?: SceneHits } & SceneRays) | null): SceneHits;
  any<B extends Uint8Array>(rays: Float32Array, options: { occluded: B } & SceneRays): B;
  any(rays: Float32Array, options?: ({ occluded?: Bytes } & SceneRays) | null): Bytes;
  allHits(rays: Float32Array, options?: ({ most?: number } & Omit<SceneRays, "filter">) | null): AllSceneHits;
  closestPoint(points: Float32Array, options?: { radius?: number; mask?: number; time?: number } | null): ClosestScenePoints;

  free(): void;
}

/**
 * An empty scene. WebAssembly has at most 4 GiB for it and all its meshes.
 * @throws TypeError if `wasm` is none of the package's files, or of trees alone; Error if it cannot be loaded
 */
export function createScene(options?: EngineOptions | null): Promise<Scene>;

/** Whether WebAssembly has SIMD here. */
export function hasSimd(): boolean;
