// A worker: does what the page says, and between two messages renders its share of the tiles.

import { Broken, Engine } from "./engine.js";

/** Milliseconds of rendering between two looks at the messages. */
const SLICE = 12;
/** Milliseconds between two words about a function that takes long. */
const REPORT = 250;

let engine = null;
/** What is being rendered: { id }, or null. */
let job = null;

/** Comes back to work after the messages that wait. */
const turn = new MessageChannel();
turn.port1.onmessage = () => guard(job?.id, render);

const actions = {
  load({ module }) {
    let [rays, last] = [0, 0];
    engine = new Engine(module, (more) => {
      rays += more;
      const now = performance.now();
      if (now - last > REPORT) {
        postMessage({ kind: "progress", rays });
        [rays, last] = [0, now];
      }
    });
  },

  open({ id, files, name }) {
    const summary = engine.open(files, name);
    job = null;
    postMessage({ kind: "opened", id, summary });
  },

  fill({ id, view, cache }) {
    job = null;
    const filled = engine.fill(view, cache);
    postMessage({ kind: "filled", id, ...filled }, [filled.dots.buffer, filled.cache.buffer]);
  },

  render({ id, view, number, count, cache }) {
    engine.start(view, number, count, cache);
    // One turn is always under way while there is a job.
    const idle = job === null;
    job = { id };
    if (idle) {
      turn.port2.postMessage(null);
    }
  },
};

onmessage = ({ data }) => guard(data.id, () => actions[data.kind](data));

function render() {
  if (job === null) {
    return;
  }
  const end = performance.now() + SLICE;
  // Of a tile that was rendered twice the latest will do.
  const tiles = new Map();
  let [samples, rays, step] = [0, 0, null];
  do {
    step = engine.step();
    if (step !== null) {
      samples += step.samples;
      rays += step.rays;
      tiles.set(`${step.x} ${step.y}`, step);
    }
  } while (step !== null && performance.now() < end);
  const list = [...tiles.values()];
  postMessage({ kind: "tiles", id: job.id, tiles: list, samples, rays }, list.map((tile) => tile.pixels.buffer));
  if (step === null) {
    postMessage({ kind: "done", id: job.id });
    job = null;
  } else {
    turn.port2.postMessage(null);
  }
}

/** Runs something, and tells the page of what goes wrong. */
function guard(id, run) {
  try {
    run();
  } catch (error) {
    postMessage({ kind: "failed", id, message: error.message, broken: error instanceof Broken });
  }
}
