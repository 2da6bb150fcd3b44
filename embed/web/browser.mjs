// A static server without any special headers, and a browser that looks at it.

import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

import { chromium } from "playwright-core";

const TYPES = { ".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".wasm": "application/wasm", ".png": "image/png" };

/** Serves the page, and `folder` as /native/; the address, and a function that ends it. */
export async function serve(folder) {
  const roots = { page: fileURLToPath(new URL("dist", import.meta.url)), native: folder };
  const server = createServer(async ({ url }, response) => {
    const path = normalize(decodeURIComponent(new URL(url, "http://localhost").pathname));
    const native = path.startsWith("/native/");
    const name = native ? path.slice("/native".length) : path.endsWith("/") ? `${path}index.html` : path;
    try {
      const bytes = await readFile(join(native ? roots.native : roots.page, name));
      response.writeHead(200, { "content-type": TYPES[extname(name)] ?? "application/octet-stream" }).end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { address: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

/** Chromium without a window, from CHROMIUM or where Debian has it. */
export function launch() {
  const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
  // Root, as in containers, has no sandbox.
  const args = process.getuid?.() === 0 ? ["--no-sandbox"] : [];
  return chromium.launch({ executablePath, args });
}
