// Where the WebAssembly comes from: beside this file, or from the caller.

import { tagOf, typeName } from "./checks.js";
import { hasSimd } from "./simd.js";

/** Where the modules are, written out for bundlers: plain and with SIMD, for trees alone and for scenes, which is larger. */
const URLS = {
  tree: [
    () => new URL("halfdome.wasm", import.meta.url),
    () => new URL("halfdome-simd.wasm", import.meta.url),
  ],
  scene: [
    () => new URL("halfdome-scene.wasm", import.meta.url),
    () => new URL("halfdome-scene-simd.wasm", import.meta.url),
  ],
};

/** Compiled modules by their addresses, which all trees share, or all scenes. */
const modules = new Map();

/** What an instance for `what` exports, from `wasm` or else from beside this file, with SIMD if that is wanted and there is any. */
export async function load(what, { simd = true, wasm } = {}) {
  const own = wasm === undefined || wasm === null;
  const module = own ? await fromUrl(urlOf(what, Boolean(simd) && hasSimd())) : await given(await wasm);
  const names = WebAssembly.Module.exports(module).map(({ name }) => name);
  if (!names.includes("add_mesh") || !names.includes("has_room")) {
    throw new TypeError("wasm should be one of the .wasm files of this version of the package");
  }
  if (what === "scene" && !names.includes("commit")) {
    throw new TypeError("wasm has trees alone: scenes need halfdome-scene.wasm or halfdome-scene-simd.wasm");
  }
  return (await WebAssembly.instantiate(module)).exports;
}

function urlOf(what, simd) {
  try {
    return URLS[what][Number(simd)]();
  } catch (error) {
    // Bundles that are no ES modules may have no import.meta.url.
    throw new Error("where the .wasm files are is not known in this bundle: hand one over as the option `wasm`", { cause: error });
  }
}

/** The module that the caller hands over. */
async function given(wasm) {
  switch (tagOf(wasm)) {
    case "WebAssembly.Module":
      return wasm;
    case "String":
      return fromUrl(new URL(wasm, globalThis.document?.baseURI ?? globalThis.location?.href));
    case "URL":
      return fromUrl(wasm);
    case "Response":
      return WebAssembly.compile(await bytesOf(wasm));
    case "ArrayBuffer":
    case "Uint8Array":
      return WebAssembly.compile(wasm);
    default:
      throw new TypeError(
        `wasm is ${typeName(wasm)}, and should be a URL, a Response, an ArrayBuffer, a Uint8Array or a WebAssembly.Module`,
      );
  }
}

function fromUrl(url) {
  const { href } = url;
  if (!modules.has(href)) {
    const module = fetchBytes(url).then((bytes) => WebAssembly.compile(bytes));
    // What failed for want of a network may work the next time.
    module.catch(() => modules.delete(href));
    modules.set(href, module);
  }
  return modules.get(href);
}

async function fetchBytes(url) {
  // Node.js fetches no files.
  return url.protocol === "file:" && globalThis.process?.versions?.node ? readFile(url) : bytesOf(await fetch(url));
}

async function readFile(url) {
  // Not `import("node:…")`, which bundlers for browsers would look for.
  const name = "node:fs/promises";
  const files = globalThis.process.getBuiltinModule?.(name) ?? (await import(/* webpackIgnore: true */ /* @vite-ignore */ name));
  return files.readFile(url);
}

async function bytesOf(response) {
  if (!response.ok) {
    const { url, status, statusText } = response;
    throw new Error(`${url}: ${status} ${statusText}: its .wasm file should be there, or be handed over as the option \`wasm\``);
  }
  return response.arrayBuffer();
}
