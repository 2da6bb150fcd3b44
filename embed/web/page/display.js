// The canvases, and the numbers beside them.

/** The radius of a dot in pixels of the upper canvas, which has the same number of them whatever the picture has. */
const DOT_RADIUS = 2.5;

export class Display {
  #picture = document.querySelector("#picture");
  #dots = document.querySelector("#dots");
  #context = this.#picture.getContext("2d", { alpha: false });
  #start = 0;
  #samples = 0;
  #rays = 0;
  #spp = 1;

  /** Begins with a view of `size` by `size` pixels; what is there stays until tiles come over it. */
  begin(size, spp) {
    if (this.#picture.width !== size) {
      this.#picture.width = this.#picture.height = size;
    }
    [this.#start, this.#samples, this.#rays, this.#spp] = [performance.now(), 0, 0, spp];
  }

  /** Shows tiles, and counts what they took. */
  tiles({ tiles, samples, rays }) {
    for (const { x, y, width, height, pixels } of tiles) {
      this.#context.putImageData(new ImageData(pixels, width, height), x, y);
    }
    this.#samples += samples;
    this.count(rays);
    const per = this.#samples / (this.#picture.width * this.#picture.height);
    text("#samples", `${Math.min(this.#spp, per).toFixed(per < 1 ? 2 : 0)} of ${this.#spp}`);
  }

  /** Counts rays that no tile has to show. */
  count(rays) {
    this.#rays += rays;
    const seconds = (performance.now() - this.#start) / 1000;
    text("#rate", `${(this.#rays / 1e6 / Math.max(seconds, 1e-3)).toFixed(2)} million`);
    text("#time", `${seconds.toFixed(1)} s`);
  }

  /** Draws a dot at each point of the picture; x and y in turn. */
  dots(points) {
    const context = this.#dots.getContext("2d");
    context.clearRect(0, 0, this.#dots.width, this.#dots.height);
    context.fillStyle = "#ff5a36";
    context.beginPath();
    const scale = this.#dots.width / this.#picture.width;
    for (let i = 0; i < points.length; i += 2) {
      const [x, y] = [scale * points[i], scale * points[i + 1]];
      context.moveTo(x + DOT_RADIUS, y);
      context.arc(x, y, DOT_RADIUS, 0, 2 * Math.PI);
    }
    context.fill();
  }
}

/** Writes text into the element that a selector finds. */
export function text(selector, value) {
  document.querySelector(selector).textContent = value;
}

/** Tells of something, or of an error. */
export function say(message, isError = false) {
  const element = document.querySelector("#message");
  element.textContent = message;
  element.classList.toggle("error", isError);
}
