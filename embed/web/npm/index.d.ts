/** What a ray is in a Float32Array: origin x, y, z, least t, direction x, y, z, greatest t. */
export const RAY_FLOATS: 8;

export interface BuildOptions {
  /** How much time to spend on a tree that is quick to trace; "high" unless told otherwise. */
  quality?: "fast" | "medium" | "high";
  /** false: the build without SIMD, even where there is SIMD. Hits are the same to the bit. */
  simd?: boolean;
}

/** The nearest hits of a batch, one element for each ray. */
export interface Hits {
  /** Distance in lengths of the ray's direction; Infinity where nothing is hit. */
  t: Float32Array;
  /** Barycentric weight of the triangle's second corner; 0 where nothing is hit. */
  u: Float32Array;
  /** Barycentric weight of the triangle's third corner; 0 where nothing is hit. */
  v: Float32Array;
  /** Number of the triangle, or -1 where nothing is hit. Of equally near ones the lowest. */
  triangle: Int32Array;
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
   * The nearest hit of each ray, written into `hits` if they are given.
   * @param rays 8 numbers for each ray, see RAY_FLOATS. Directions need no unit length; one of length 0 hits nothing.
   * @throws TypeError if an argument is of the wrong type, or after free()
   * @throws RangeError if a length is wrong, or a number of a ray is NaN
   */
  closest(rays: Float32Array, hits?: Hits): Hits;

  /**
   * Whether each ray hits anything, 1 or 0: quicker than closest().
   * @throws as closest() does
   */
  any(rays: Float32Array, occluded?: Uint8Array): Uint8Array;

  /** Gives the memory back; without it that happens when nothing refers to the tree any more. */
  free(): void;
}

/**
 * Builds a tree.
 * @param positions x, y, z of each vertex, finite and not beyond ±2^42
 * @param indices three vertices for each triangle; without them, every three vertices are one
 * @throws TypeError if an argument is of the wrong type
 * @throws RangeError if a length or a number is wrong, or there is no memory left
 */
export function build(
  positions: Float32Array,
  indices?: Uint32Array | Uint16Array | null,
  options?: BuildOptions,
): Promise<Tree>;

/** Whether WebAssembly has SIMD here. */
export function hasSimd(): boolean;
