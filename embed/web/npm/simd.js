// Whether WebAssembly has SIMD here.

/** A module whose one function needs it: (func (drop (v128.const i64x2 0 0))). */
const PROBE = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 4, 1, 96, 0, 0, 3, 2, 1, 0, 10, 23, 1, 21, 0, 253, 12, ...new Array(16).fill(0), 26,
  11,
]);

export function hasSimd() {
  return WebAssembly.validate(PROBE);
}
