// A WebAssembly instance of the renderer. What its functions do stands in src/lib.rs.

const DONE = 0;
const NOTHING = 2;
const HEADER = 24;

/** What the input was at fault for; the instance goes on. */
export class Refused extends Error {}

/** What ended the instance: a panic, or no memory left. */
export class Broken extends Error {}

export class Engine {
  #exports;
  #panic = null;

  /** `progress` hears of rays while a function takes long. */
  constructor(module, progress) {
    const panicked = (address, length) => {
      this.#panic = new TextDecoder().decode(new Uint8Array(this.#exports.memory.buffer, address, length));
    };
    this.#exports = new WebAssembly.Instance(module, { page: { progress, panicked } }).exports;
    this.#exports.init();
  }

  /** Opens the model `name` among the files ({ name, bytes }), or without a name the Cornell box; gives its summary. */
  open(files, name) {
    for (const file of files) {
      this.#write(file.bytes, encode(file.name));
      this.#call(() => this.#exports.add_file(file.bytes.byteLength));
    }
    this.#write(encode(name));
    return JSON.parse(new TextDecoder().decode(this.#call(() => this.#exports.open())));
  }

  /** Fills the cache for a view, from the records in `cache` if there are any; gives the cache and where dots are. */
  fill(view, cache) {
    this.#take(cache);
    this.#write(encode(JSON.stringify(view)));
    const answer = this.#call(() => this.#exports.fill()).slice();
    const count = new DataView(answer.buffer).getUint32(0, true);
    return { dots: new Float32Array(answer.buffer, 4, 2 * count), cache: answer.slice(4 + 8 * count) };
  }

  /** Prepares to render a view as one of `count` workers. */
  start(view, number, count, cache) {
    this.#take(cache);
    this.#write(encode(JSON.stringify(view)));
    this.#call(() => this.#exports.start(number, count));
  }

  /** Renders a tile a little further; null if all is done. */
  step() {
    const answer = this.#call(() => this.#exports.step());
    if (answer === null) {
      return null;
    }
    const [x, y, width, height, samples, rays] = new Uint32Array(answer.slice(0, HEADER).buffer);
    return { x, y, width, height, samples, rays, pixels: new Uint8ClampedArray(answer.slice(HEADER).buffer) };
  }

  #take(cache) {
    if (cache) {
      this.#write(cache);
      this.#call(() => this.#exports.cache());
    }
  }

  /** Writes bytes where the next function reads them. */
  #write(...parts) {
    const length = parts.reduce((sum, part) => sum + part.byteLength, 0);
    const address = this.#call(() => this.#exports.input(length), false) >>> 0;
    if (address === 0) {
      throw new Refused("There is no memory left for this file.");
    }
    let at = address;
    for (const part of parts) {
      new Uint8Array(this.#exports.memory.buffer, at, part.byteLength).set(new Uint8Array(part.buffer ?? part));
      at += part.byteLength;
    }
  }

  /** What a function answers, or what it gives if that is no code. */
  #call(run, answers = true) {
    let code;
    try {
      code = run();
    } catch (error) {
      throw new Broken(this.#panic ?? `The renderer has no memory left (${error.message}).`);
    }
    if (!answers) {
      return code;
    }
    const { memory, output, output_length } = this.#exports;
    if (code === NOTHING) {
      return null;
    }
    const answer = new Uint8Array(memory.buffer, output() >>> 0, output_length() >>> 0);
    if (code !== DONE) {
      throw new Refused(new TextDecoder().decode(answer));
    }
    return answer;
  }
}

function encode(text) {
  return new TextEncoder().encode(text);
}
