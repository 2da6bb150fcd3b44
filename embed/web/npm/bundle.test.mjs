// Runs under `node --test`: bundles for browsers and Node.js find the package's WebAssembly, or take what they are handed; and its types.
import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { cp, mkdtemp, mkdir, rm, symlink, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";

import * as esbuild from "esbuild";
import webpack from "webpack";

import { launch, serve } from "../browser.mjs";

const run = promisify(execFile);
const PACKAGE = fileURLToPath(new URL(".", import.meta.url));

/** Traces a tree and a scene; the options of each are in place of TREE and SCENE. */
const APP = `
  import { build, createScene } from "halfdome";
  import { raysOf } from "halfdome/three";
  const positions = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]);
  const rays = raysOf([{ origin: { x: 0.25, y: 0.25, z: 5 }, direction: { x: 0, y: 0, z: -1 } }]);
  async function main() {
    const tree = await build(positions, null, TREE);
    const scene = await createScene(SCENE);
    scene.insert(scene.addMesh(positions));
    scene.commit();
    return "hits at " + tree.closest(rays).t[0] + " and " + scene.closest(rays).t[0];
  }
  main().catch((error) => error.message).then((text) => globalThis.document ? (document.body.dataset.said = text) : console.log(text));
`;
const EXPECTED = "hits at 5 and 5";

let folder, browser, server;

before(async () => {
  folder = await mkdtemp(join(tmpdir(), "halfdome-bundle-"));
  await mkdir(join(folder, "node_modules"));
  await symlink(PACKAGE, join(folder, "node_modules", "halfdome"));
  [browser, server] = await Promise.all([launch(), serve(folder)]);
});

after(async () => {
  await browser?.close();
  server?.close();
  await rm(folder, { recursive: true, force: true });
});

/** An entry for a bundler, in a folder of its own. */
async function entry(name, tree = "{}", scene = "{}", head = "") {
  await mkdir(join(folder, name));
  const path = join(folder, name, "app.js");
  await writeFile(path, head + APP.replace("TREE", tree).replace("SCENE", scene));
  return path;
}

/** Puts the package's .wasm files beside a bundle. */
function copyWasm(name) {
  return cp(PACKAGE, join(folder, name), { recursive: true, filter: (path) => path === PACKAGE || path.endsWith(".wasm") });
}

/** What a script says in a page. */
async function inBrowser(name, script, type) {
  await writeFile(join(folder, name, "index.html"), `<!doctype html><body><script type="${type}" src="${script}"></script>`);
  const page = await browser.newPage();
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  await page.goto(`${server.address}native/${name}/index.html`);
  await page.waitForFunction(() => document.body.dataset.said !== undefined, null, { timeout: 30_000 });
  const said = await page.getAttribute("body", "data-said");
  await page.close();
  assert.deepEqual(errors, []);
  return said;
}

const inNode = async (name, script) => (await run("node", [join(folder, name, script)])).stdout.trim();

async function byEsbuild(name, path, options) {
  const { warnings } = await esbuild.build({ entryPoints: [path], bundle: true, outdir: join(folder, name), logLevel: "silent", ...options });
  return warnings.map(({ text }) => text);
}

async function byWebpack(name, path, options) {
  const stats = await promisify(webpack)({
    mode: "production",
    entry: path,
    output: { path: join(folder, name, "out"), filename: "app.cjs" },
    performance: { hints: false },
    ...options,
  });
  const { errors, warnings } = stats.toJson({ all: false, errors: true, warnings: true });
  assert.deepEqual([errors, warnings], [[], []]);
}

test("esbuild, for browsers", async () => {
  const path = await entry("esbuild-web");
  assert.deepEqual(await byEsbuild("esbuild-web", path, { format: "esm", minify: true, outExtension: { ".js": ".out.js" } }), []);
  await copyWasm("esbuild-web");
  assert.equal(await inBrowser("esbuild-web", "app.out.js", "module"), EXPECTED);
});

test("esbuild as it is, which knows no import.meta, with files and bytes that are handed over", async () => {
  const bare = await entry("esbuild-bare");
  await byEsbuild("esbuild-bare", bare, { outExtension: { ".js": ".out.js" } });
  const message = "where the .wasm files are is not known in this bundle: hand one over as the option `wasm`";
  assert.equal(await inBrowser("esbuild-bare", "app.out.js", "text/javascript"), message);

  const head = 'import trees from "halfdome/halfdome.wasm"; import scenes from "halfdome/halfdome-scene.wasm";';
  for (const [name, loader] of [["esbuild-file", "file"], ["esbuild-binary", "binary"]]) {
    const path = await entry(name, "{ wasm: trees }", "{ wasm: scenes }", head);
    await byEsbuild(name, path, { loader: { ".wasm": loader }, outExtension: { ".js": ".out.js" } });
    assert.equal(await inBrowser(name, "app.out.js", "text/javascript"), EXPECTED, loader);
  }
  const fetched = await entry("esbuild-fetch", '{ wasm: fetch("halfdome.wasm") }', '{ wasm: new URL("halfdome-scene.wasm", location) }');
  await byEsbuild("esbuild-fetch", fetched, { outExtension: { ".js": ".out.js" } });
  await copyWasm("esbuild-fetch");
  assert.equal(await inBrowser("esbuild-fetch", "app.out.js", "text/javascript"), EXPECTED);
});

test("esbuild, for Node.js", async () => {
  const path = await entry("esbuild-node");
  assert.deepEqual(await byEsbuild("esbuild-node", path, { platform: "node", format: "esm", outExtension: { ".js": ".mjs" } }), []);
  await copyWasm("esbuild-node");
  assert.equal(await inNode("esbuild-node", "app.mjs"), EXPECTED);
});

test("webpack, for browsers and Node.js", async () => {
  const web = await entry("webpack-web");
  await byWebpack("webpack-web", web, { output: { path: join(folder, "webpack-web"), filename: "out.js" } });
  assert.equal(await inBrowser("webpack-web", "out.js", "text/javascript"), EXPECTED);
  const node = await entry("webpack-node");
  await byWebpack("webpack-node", node, { target: "node" });
  assert.equal(await inNode("webpack-node", join("out", "app.cjs")), EXPECTED);
});

test("a page without a bundler", async () => {
  const name = "plain";
  await entry(name);
  await writeFile(join(folder, name, "app.js"), APP.replace("TREE", "null").replace("SCENE", "null")
    .replace('"halfdome"', '"../node_modules/halfdome/index.js"').replace('"halfdome/three"', '"../node_modules/halfdome/three.js"'));
  assert.equal(await inBrowser(name, "app.js", "module"), EXPECTED);
});

test("the types, as TypeScript checks them strictly", async () => {
  await mkdir(join(folder, "types"));
  await writeFile(join(folder, "package.json"), '{ "type": "module" }');
  await writeFile(join(folder, "types", "app.ts"), `
    import { build, createScene, type HitArrays, type Hits, type Mesh, type SceneHits, type Tree } from "halfdome";
    const rays = new Float32Array(8);
    const tree: Tree = await build(new Float32Array(9), new Uint16Array(0), { wasm: fetch("halfdome.wasm") });
    const hits: Hits = tree.closest(rays, { filter: ({ triangle }) => triangle > 3 });
    // Buffers of their own.
    new Blob([hits.t, tree.closest(rays, null).triangle, tree.any(rays), tree.closestPoint(rays).position, tree.allHits(rays).starts]);
    postMessage(hits, { transfer: [hits.t.buffer] });
    tree.closest(rays, { hits }).u.length;
    const floats = () => new Float32Array(new SharedArrayBuffer(4));
    const shared: HitArrays = { t: floats(), u: floats(), v: floats(), triangle: new Int32Array(new SharedArrayBuffer(4)) };
    tree.closest(rays, { hits: shared });
    const occluded: Uint8Array = tree.any(rays, { occluded: new Uint8Array(1) });
    const scene = await createScene(null);
    const mesh: Mesh = scene.addMesh(new Float32Array(9), null, null);
    const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1] as const;
    scene.insert(mesh, { transform: identity }).setTransforms([identity, new Float32Array(16)]);
    const found: SceneHits = scene.closest(rays, { mask: 1, time: new Float32Array(1) });
    new Blob([scene.closest(rays, { hits: found }).instance]);
    mesh.free();
    export { occluded };
  `);
  const tsc = fileURLToPath(new URL("../node_modules/.bin/tsc", import.meta.url));
  const options = ["--noEmit", "--strict", "--target", "es2022", "--module", "nodenext", "--lib", "es2022,dom", "types/app.ts"];
  const { stdout } = await run(tsc, options, { cwd: folder }).catch((error) => error);
  assert.equal(stdout, "");
});
