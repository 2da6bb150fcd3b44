// The page: what is to be seen, and who renders it.
//
// The address may say what the controls do, and more: ?mode=ao&size=256&spp=16&workers=2&simd=no

import { Display, say, text } from "./display.js";
import { aim, steer } from "./orbit.js";
import { compile, Pool } from "./pool.js";

const MOST_WORKERS = 16;
const MODELS = /\.(glb|gltf|obj|ply)$/i;
const MOST_PIXELS = 4096;

const address = new URLSearchParams(location.search);
const controls = document.querySelector("#controls");
const display = new Display();

/** What is to be seen. The address may ask for sizes and samples that the lists lack. */
const wish = {
  mode: choice("mode", ["path", "ao", "cached"], "path"),
  size: number("size", 512, MOST_PIXELS),
  spp: number("spp", 64, 65536),
};
const scene = { summary: null, pose: null };
/** The records of the scene so far, and where the view shows them. */
const records = { cache: null, dots: new Float32Array(0) };
let pool = null;
let moving = false;
let busy = 0;
let frame = 0;

const listener = {
  tiles: (data) => display.tiles(data),
  progress: (rays) => display.count(rays),
  filled({ dots, cache }) {
    [records.cache, records.dots] = [cache, dots];
    showDots();
    render("cached", wish.spp);
  },
  done() {
    busy -= 1;
    if (busy === 0 && document.body.dataset.state === "rendering") {
      document.body.dataset.state = "done";
    }
  },
  failed(message) {
    document.body.dataset.state = "failed";
    say(message, true);
  },
};

/** Renders what is wished for, or while the camera moves what is quick. */
function show() {
  if (wish.mode !== "cached" || moving) {
    render(moving && wish.mode === "cached" ? "path" : wish.mode, wish.spp);
    return;
  }
  // The first worker fills the cache; meanwhile the others have something to look at.
  render("path", 1, Math.min(1, pool.size - 1));
  document.body.dataset.state = "filling";
  pool.fill(view("cached", wish.spp), records.cache);
}

function render(integrator, spp, but = 0) {
  document.body.dataset.state = "rendering";
  display.begin(wish.size, spp);
  busy = pool.render(view(integrator, spp), integrator === "cached" ? records.cache : null, but);
}

function view(integrator, spp) {
  return { width: wish.size, height: wish.size, spp, integrator, camera: scene.pose };
}

/** Shows at the next frame, however often it is asked to. */
function showSoon() {
  cancelAnimationFrame(frame);
  frame = requestAnimationFrame(show);
}

function showDots() {
  const wanted = wish.mode === "cached" && !moving && document.querySelector("#show-records").checked;
  display.dots(wanted ? records.dots : new Float32Array(0));
  text("#records", records.dots.length > 0 ? (records.dots.length / 2).toLocaleString("en") : "–");
}

/** Opens a model among the files, or the Cornell box. What cannot be read leaves all as it was. */
async function open(files) {
  const model = files.find((file) => MODELS.test(file.name));
  try {
    if (files.length > 0 && !model) {
      throw new Error(`${files[0].name}: this is no model\n  help: give a .glb, .gltf, .obj or .ply file, and the files that it names`);
    }
    say(model ? `Opening ${model.name} …` : "");
    const read = await Promise.all(files.map(async (file) => ({ name: file.name, bytes: await file.arrayBuffer() })));
    const summary = await pool.open(read, model?.name ?? "");
    scene.summary = summary;
    scene.pose = summary.camera;
    [records.cache, records.dots] = [null, new Float32Array(0)];
    const triangles = `${summary.triangles.toLocaleString("en")} triangle${summary.triangles === 1 ? "" : "s"}`;
    text("#scene", `${model?.name ?? "Cornell box"}, ${triangles}`);
    say(summary.warnings.join("\n"));
  } catch (error) {
    say(error.message, true);
  }
  if (scene.summary) {
    showDots();
    show();
  }
}

function listen() {
  controls.addEventListener("submit", (event) => event.preventDefault());
  controls.addEventListener("change", ({ target }) => {
    if (target.name === "mode") {
      wish.mode = target.value;
    } else if (target.id === "size" || target.id === "spp") {
      wish[target.id] = Number(target.value);
      records.dots = new Float32Array(0);
    } else {
      showDots();
      return;
    }
    showDots();
    show();
  });
  document.querySelector("#open").addEventListener("change", ({ target }) => {
    open([...target.files]);
    target.value = "";
  });
  document.querySelector("#cornell").addEventListener("click", () => open([]));
  document.querySelector("#reset").addEventListener("click", () => {
    scene.pose = scene.summary.camera;
    rest();
  });

  const rest = () => {
    moving = false;
    showDots();
    show();
  };
  const move = (change) => {
    moving = true;
    scene.pose = change(aim(scene.pose, scene.summary.bounds));
    records.dots = new Float32Array(0);
    showDots();
    showSoon();
  };
  steer(document.querySelector("#picture"), move, rest);

  addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) {
      document.body.classList.remove("dropping");
    }
  });
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    if (event.dataTransfer.files.length > 0) {
      open([...event.dataTransfer.files]);
    }
  });
}

function choice(name, known, otherwise) {
  const value = address.get(name);
  return known.includes(value) ? value : otherwise;
}

function number(name, otherwise, most) {
  const value = Number(address.get(name));
  return Number.isInteger(value) && value >= 1 && value <= most ? value : otherwise;
}

/** Sets a list to a value that it may lack. */
function select(selector, value) {
  const list = document.querySelector(selector);
  if (![...list.options].some((option) => option.value === String(value))) {
    list.add(new Option(value, value));
  }
  list.value = value;
}

try {
  controls.mode.value = wish.mode;
  select("#size", wish.size);
  select("#spp", wish.spp);
  const { module, simd } = await compile(address.get("simd") !== "no");
  pool = new Pool(module, number("workers", Math.min(MOST_WORKERS, navigator.hardwareConcurrency ?? 2), MOST_WORKERS), listener);
  text("#workers", `${pool.size}, ${simd ? "with" : "without"} SIMD`);
  listen();
  await open([]);
} catch (error) {
  listener.failed(`The renderer cannot be loaded: ${error.message}`);
}
