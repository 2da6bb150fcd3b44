// A scene that moves, traced by the package halfdome: each frame all rings move, the scene commits, and rays make the picture.
//
// The address may say more: ?width=320&height=240&simd=no, and ?time=2.5 to stop the clock there.

import { createScene } from "./halfdome/index.js";
import { RINGS, World } from "./world.js";

const address = new URLSearchParams(location.search);
const element = (name) => document.querySelector(`#${name}`);

function number(name, otherwise, most) {
  const wish = Number(address.get(name) ?? otherwise);
  return wish > 0 && wish <= most ? wish : otherwise;
}

async function run() {
  const canvas = document.querySelector("#picture");
  canvas.width = Math.ceil(number("width", 320, 2048));
  canvas.height = Math.ceil(number("height", 240, 2048));
  const context = canvas.getContext("2d");
  const scene = await createScene({ simd: address.get("simd") !== "no" });
  const world = new World(scene);
  element("rings").textContent = `${RINGS} moving rings of 576 triangles, ${scene.simd ? "with" : "without"} SIMD`;
  const stopped = address.has("time") ? Number(address.get("time")) : null;
  let smooth = null;

  function frame(now) {
    const start = performance.now();
    world.move(stopped ?? now / 1000);
    const moved = performance.now();
    const { bytes, rays } = world.picture(canvas.width, canvas.height);
    const traced = performance.now();
    context.putImageData(new ImageData(bytes, canvas.width, canvas.height), 0, 0);
    const times = [moved - start, traced - moved];
    smooth = smooth === null ? times : smooth.map((time, i) => 0.95 * time + 0.05 * times[i]);
    element("commit").textContent = `${smooth[0].toFixed(2)} ms`;
    element("trace").textContent = `${smooth[1].toFixed(1)} ms for ${rays} rays and their shading`;
    if (stopped === null) {
      requestAnimationFrame(frame);
    } else {
      document.body.dataset.state = "done";
    }
  }
  frame(performance.now());
}

run().catch((error) => {
  document.body.dataset.state = "failed";
  element("message").textContent = error.message;
});
