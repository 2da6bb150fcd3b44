// A scene of rings that move, and its picture: one camera ray a pixel, and a shadow ray from where it ends.

export const RINGS = 100;
const RAY_FLOATS = 8;
const SUN = unit([0.4, 0.8, 0.45]);
const EYE = [0, 5.5, 11];
const TARGET = [0, 0.6, 0];
/** Of half of the picture's height, at a distance of 1. */
const TANGENT = 0.42;
const SKY = [0.55, 0.7, 0.9];
const FLOOR_COLOR = [0.55, 0.53, 0.5];
const AMBIENT = 0.25;

/** A ring in the plane of x and z, around the origin: positions, indices, and the unit normal of each triangle. */
function ring(radius, thickness, around, across) {
  const positions = [];
  const indices = [];
  for (let i = 0; i < around; i++) {
    for (let j = 0; j < across; j++) {
      const [a, b] = [(2 * Math.PI * i) / around, (2 * Math.PI * j) / across];
      const distance = radius + thickness * Math.cos(b);
      positions.push(distance * Math.cos(a), thickness * Math.sin(b), distance * Math.sin(a));
      const at = (i, j) => (i % around) * across + (j % across);
      indices.push(at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1));
    }
  }
  return mesh(positions, indices);
}

function mesh(positions, indices) {
  const corner = (i) => positions.slice(3 * indices[i], 3 * indices[i] + 3);
  const normals = [];
  for (let i = 0; i < indices.length; i += 3) {
    const [a, b, c] = [corner(i), corner(i + 1), corner(i + 2)];
    normals.push(...unit(cross(minus(b, a), minus(c, a))));
  }
  return { positions: new Float32Array(positions), indices: new Uint32Array(indices), normals };
}

/** The scene, in a scene of the package. */
export class World {
  #scene;
  #rings = [];
  #ring = ring(0.42, 0.14, 24, 12);
  #floor = mesh([-40, 0, -40, 40, 0, -40, 40, 0, 40, -40, 0, 40], [0, 2, 1, 0, 3, 2]);
  #floorNumber;

  constructor(scene) {
    this.#scene = scene;
    const shape = scene.addMesh(this.#ring.positions, this.#ring.indices);
    for (let i = 0; i < RINGS; i++) {
      this.#rings.push({ instance: scene.insert(shape), matrix: new Float32Array(16) });
    }
    this.#floorNumber = scene.insert(scene.addMesh(this.#floor.positions, this.#floor.indices)).number;
  }

  /** Moves everything to where it is after so many seconds. */
  move(seconds) {
    this.#rings.forEach(({ instance, matrix }, i) => {
      const [orbit, place] = [1 + (i % 5), Math.floor(i / 5)];
      const angle = (2 * Math.PI * place) / (RINGS / 5) + (seconds * (orbit % 2 === 0 ? 0.5 : -0.5)) / orbit;
      const height = 1 + 0.45 * Math.sin(1.7 * seconds + i);
      const [tilt, turn] = [seconds + 2.4 * i, 0.6 * seconds + i];
      const [st, ct, sr, cr] = [Math.sin(tilt), Math.cos(tilt), Math.sin(turn), Math.cos(turn)];
      matrix.set([cr, 0, -sr, 0, sr * st, ct, cr * st, 0, sr * ct, -st, cr * ct, 0]);
      matrix.set([1.15 * orbit * Math.cos(angle), height, 1.15 * orbit * Math.sin(angle), 1], 12);
      instance.setTransform(matrix);
    });
    this.#scene.commit();
  }

  /** The picture as it is now, as bytes of red, green, blue and alpha; how many rays it took. */
  picture(width, height) {
    const rays = cameraRays(width, height);
    const hits = this.#scene.closest(rays);
    const bytes = new Uint8ClampedArray(4 * width * height);
    const lit = [];
    for (let pixel = 0; pixel < width * height; pixel++) {
      if (hits.triangle[pixel] < 0) {
        paint(bytes, pixel, SKY, 1);
        continue;
      }
      const normal = this.#normal(hits, pixel);
      const cosine = dot(normal, SUN);
      if (cosine > 0) {
        lit.push({ pixel, cosine });
      }
      paint(bytes, pixel, this.#color(hits.instance[pixel]), AMBIENT);
    }
    const shadows = new Float32Array(RAY_FLOATS * lit.length);
    lit.forEach(({ pixel }, i) => {
      const ray = rays.subarray(RAY_FLOATS * pixel, RAY_FLOATS * (pixel + 1));
      for (let axis = 0; axis < 3; axis++) {
        shadows[RAY_FLOATS * i + axis] = ray[axis] + hits.t[pixel] * ray[4 + axis];
        shadows[RAY_FLOATS * i + 4 + axis] = SUN[axis];
      }
      // The first millimetre is the surface's own.
      shadows.set([1e-3], RAY_FLOATS * i + 3);
      shadows.set([Infinity], RAY_FLOATS * i + 7);
    });
    const occluded = this.#scene.any(shadows);
    lit.forEach(({ pixel, cosine }, i) => {
      if (!occluded[i]) {
        paint(bytes, pixel, this.#color(hits.instance[pixel]), AMBIENT + cosine);
      }
    });
    return { bytes, rays: width * height + lit.length };
  }

  /** The unit normal of what was hit, where it is in the world. */
  #normal(hits, pixel) {
    const [number, triangle] = [hits.instance[pixel], hits.triangle[pixel]];
    const { normals } = number === this.#floorNumber ? this.#floor : this.#ring;
    const [x, y, z] = normals.slice(3 * triangle, 3 * triangle + 3);
    if (number === this.#floorNumber) {
      return [x, y, z];
    }
    // Rings are turned and not stretched.
    const m = this.#rings[number].matrix;
    return [0, 1, 2].map((row) => m[row] * x + m[4 + row] * y + m[8 + row] * z);
  }

  #color(number) {
    if (number === this.#floorNumber) {
      return FLOOR_COLOR;
    }
    const hue = 2.4 * number;
    return [0, 2.1, 4.2].map((phase) => 0.55 + 0.35 * Math.cos(hue + phase));
  }
}

function cameraRays(width, height) {
  const forward = unit(minus(TARGET, EYE));
  const right = unit(cross(forward, [0, 1, 0]));
  const up = cross(right, forward);
  const rays = new Float32Array(RAY_FLOATS * width * height);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const [across, above] = [(2 * x + 1 - width) / height, (height - 2 * y - 1) / height];
      const direction = forward.map((value, i) => value + TANGENT * (across * right[i] + above * up[i]));
      rays.set([...EYE, 0, ...direction, Infinity], RAY_FLOATS * (y * width + x));
    }
  }
  return rays;
}

/** Linear light as sRGB's codes, by its power law of 2.2. */
function paint(bytes, pixel, color, light) {
  for (let i = 0; i < 3; i++) {
    bytes[4 * pixel + i] = 255 * Math.pow(Math.min(1, color[i] * light), 1 / 2.2);
  }
  bytes[4 * pixel + 3] = 255;
}

function minus(a, b) {
  return a.map((value, i) => value - b[i]);
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function unit(a) {
  const length = Math.sqrt(dot(a, a));
  return a.map((value) => value / length);
}
