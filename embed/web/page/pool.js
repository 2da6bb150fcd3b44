// The workers, each with a WebAssembly instance of its own: they share no memory, so that no server needs special headers.

import { hasSimd } from "./simd.js";

/** Compiles the renderer, with SIMD if it is wanted and there is any. */
export async function compile(simd) {
  const file = simd && hasSimd() ? "page-simd.wasm" : "page.wasm";
  const response = await fetch(new URL(file, import.meta.url));
  if (!response.ok) {
    throw new Error(`${file}: ${response.status} ${response.statusText}`);
  }
  // Not compileStreaming, which wants a media type that some servers do not know.
  return { module: await WebAssembly.compile(await response.arrayBuffer()), simd: file !== "page.wasm" };
}

export class Pool {
  #module;
  #listener;
  #workers = [];
  /** The scene that is open: { files, name }. */
  #scene = { files: [], name: "" };
  /** What each worker was last told to render. */
  #jobs = [];
  /** Of the latest request: answers to older ones do not count. */
  #id = 0;
  #opening = null;
  #filling = false;

  /** `listener` has the methods tiles, filled, done, progress and failed. */
  constructor(module, count, listener) {
    this.#module = module;
    this.#listener = listener;
    for (let number = 0; number < count; number++) {
      this.#workers.push(this.#hire());
    }
  }

  get size() {
    return this.#workers.length;
  }

  /** Opens a model on all workers; its summary, or an error if it cannot be read: then the old scene stays. */
  async open(files, name) {
    this.#interrupt();
    const id = ++this.#id;
    const summary = await new Promise((resolve, reject) => {
      this.#opening = { id, waiting: this.size, resolve, reject };
      this.#tell({ kind: "open", id, files, name });
    });
    this.#scene = { files, name };
    return summary;
  }

  /** Renders a view on all workers but the first `but`; the cached integrator reads `cache`. */
  render(view, cache = null, but = 0) {
    this.#interrupt();
    const id = ++this.#id;
    const workers = this.#workers.slice(but);
    this.#jobs = [];
    workers.forEach((worker, number) => {
      const job = { kind: "render", id, view, number, count: workers.length, cache };
      this.#jobs[but + number] = job;
      worker.postMessage(job);
    });
    return workers.length;
  }

  /** Fills the cache on the first worker, while the others do what they are at. */
  fill(view, cache) {
    this.#filling = true;
    this.#workers[0].postMessage({ kind: "fill", id: this.#id, view, cache });
  }

  /** A worker that fills a cache hears nothing: another takes its place. */
  #interrupt() {
    if (this.#filling) {
      this.#filling = false;
      this.#replace(0);
    }
  }

  /** Replaces a worker that broke at a request. What it was told since then, it has not heard. */
  #mourn(number, id) {
    if (number < 0) {
      return;
    }
    this.#replace(number);
    const job = this.#jobs[number];
    if (job && job.id === this.#id && job.id !== id) {
      this.#workers[number].postMessage(job);
    }
  }

  #replace(number) {
    this.#workers[number].terminate();
    this.#workers[number] = this.#hire();
  }

  /** A new worker, with the scene that is open. */
  #hire() {
    const worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    worker.onmessage = ({ data }) => this.#hear(worker, data);
    worker.onerror = (event) => this.#listener.failed(`A worker cannot run: ${event.message ?? "its script is missing"}`);
    worker.postMessage({ kind: "load", module: this.#module });
    worker.postMessage({ kind: "open", id: 0, ...this.#scene });
    return worker;
  }

  #tell(message) {
    this.#workers.forEach((worker) => worker.postMessage(message));
  }

  #hear(worker, data) {
    if (data.kind === "failed" && data.broken) {
      this.#mourn(this.#workers.indexOf(worker), data.id);
    }
    if (data.kind === "progress") {
      this.#listener.progress(data.rays);
      return;
    }
    if (data.id !== this.#id) {
      return;
    }
    if (this.#opening?.id === data.id) {
      this.#opened(data);
      return;
    }
    if (data.kind === "filled" || data.kind === "failed") {
      this.#filling = false;
    }
    if (data.kind === "failed") {
      this.#listener.failed(data.message);
    } else {
      this.#listener[data.kind](data);
    }
  }

  /** Counts the workers that have opened a model, or could not. */
  #opened(data) {
    const { resolve, reject } = this.#opening;
    if (data.kind === "failed") {
      this.#opening = null;
      if (data.broken) {
        // Others may have had more luck.
        this.#tell({ kind: "open", id: 0, ...this.#scene });
      }
      reject(new Error(data.message));
    } else if (--this.#opening.waiting === 0) {
      this.#opening = null;
      resolve(data.summary);
    }
  }
}
