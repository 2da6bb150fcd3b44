// A camera that goes around a point. Poses are { eye, target, up, vfov } with points as [x, y, z].

const add = (a, b) => a.map((x, i) => x + b[i]);
const scale = (a, s) => a.map((x) => x * s);
const subtract = (a, b) => a.map((x, i) => x - b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => scale(a, 1 / Math.hypot(...a));

/** The greatest angle between the view and the horizon: straight up and down would have no direction. */
const STEEPEST = (85 / 180) * Math.PI;
/** Radians for the way across the picture. */
const TURN = 3;
const KEYS = { ArrowLeft: [-0.05, 0], ArrowRight: [0.05, 0], ArrowUp: [0, -0.05], ArrowDown: [0, 0.05] };

/** The same view with its target beside the middle of the bounds, to go around. */
export function aim(pose, [lower, upper]) {
  const middle = scale(add(lower, upper), 0.5);
  const view = unit(subtract(pose.target, pose.eye));
  const distance = dot(subtract(middle, pose.eye), view);
  return distance > 0 ? { ...pose, target: add(pose.eye, scale(view, distance)) } : pose;
}

/** The pose after going around by two angles, in radians. */
export function orbit(pose, azimuth, elevation) {
  const up = unit(pose.up);
  const from = subtract(pose.eye, pose.target);
  const distance = Math.hypot(...from);
  const height = dot(from, up);
  const flat = subtract(from, scale(up, height));
  const ahead = unit(Math.hypot(...flat) > 1e-6 * distance ? flat : cross(up, Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
  const turned = add(scale(ahead, Math.cos(azimuth)), scale(cross(up, ahead), Math.sin(azimuth)));
  const angle = Math.min(STEEPEST, Math.max(-STEEPEST, Math.asin(height / distance) + elevation));
  const offset = add(scale(turned, distance * Math.cos(angle)), scale(up, distance * Math.sin(angle)));
  return { ...pose, eye: add(pose.target, offset) };
}

/** The pose at `factor` times the distance. */
export function zoom(pose, factor) {
  return { ...pose, eye: add(pose.target, scale(subtract(pose.eye, pose.target), factor)) };
}

/**
 * Lets mouse, touch and keys on an element move a camera. `move` gets a function from pose to pose; `rest` is called when
 * the hand is off.
 */
export function steer(element, move, rest) {
  const fingers = new Map();
  let resting = 0;
  const restSoon = () => {
    clearTimeout(resting);
    resting = setTimeout(() => fingers.size === 0 && rest(), 250);
  };
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  element.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) {
      return;
    }
    const spreadBefore = fingers.size === 2 ? spread() : 0;
    const [right, down] = [event.clientX - before.x, event.clientY - before.y];
    Object.assign(before, { x: event.clientX, y: event.clientY });
    if (fingers.size === 2) {
      const factor = spreadBefore / Math.max(1, spread());
      move((pose) => zoom(pose, factor));
    } else if (fingers.size === 1 && (right !== 0 || down !== 0)) {
      const turn = TURN / element.clientWidth;
      move((pose) => orbit(pose, -right * turn, down * turn));
    }
  });
  for (const end of ["pointerup", "pointercancel"]) {
    element.addEventListener(end, (event) => {
      fingers.delete(event.pointerId);
      restSoon();
    });
  }
  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      move((pose) => zoom(pose, Math.exp(Math.sign(event.deltaY) * Math.min(0.3, 0.002 * Math.abs(event.deltaY)))));
      restSoon();
    },
    { passive: false },
  );
  element.addEventListener("keydown", (event) => {
    if (event.key in KEYS) {
      move((pose) => orbit(pose, ...KEYS[event.key]));
    } else if (event.key === "+" || event.key === "-") {
      move((pose) => zoom(pose, event.key === "+" ? 0.9 : 1 / 0.9));
    } else {
      return;
    }
    event.preventDefault();
    restSoon();
  });
}
