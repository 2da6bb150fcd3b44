// Runs under `node --test`: the page in a browser, beside what the program on this machine renders.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, beforeEach, test } from "node:test";
import { fileURLToPath } from "node:url";

import { launch, serve } from "../browser.mjs";
import { GLB, MTL, OBJ } from "./models.mjs";

const PROGRAM = process.env.HALFDOME ?? fileURLToPath(new URL("../../../target/release/halfdome", import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "halfdome-web-"));
let browser, server, page, errors;

before(async () => {
  [browser, server] = await Promise.all([launch(), serve(folder)]);
});

after(async () => {
  await browser?.close();
  server?.close();
  rmSync(folder, { recursive: true });
});

beforeEach(async () => {
  await page?.close();
  page = await browser.newPage();
  errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
});

/** Opens the page with options, and waits for its picture. */
async function visit(options) {
  await page.goto(`${server.address}?${options}`);
  await finished();
}

async function finished() {
  await page.waitForFunction(() => ["done", "failed"].includes(document.body.dataset.state), null, { timeout: 120_000 });
  assert.equal(await page.getAttribute("body", "data-state"), "done", await message());
  assert.deepEqual(errors, []);
}

const message = () => page.textContent("#message");

/** What the canvas shows, as bytes of red, green, blue and alpha. */
async function picture() {
  const bytes = await page.evaluate(() => {
    const canvas = document.querySelector("#picture");
    return [...canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data];
  });
  return Buffer.from(bytes);
}

/** The same of a picture that the program renders. */
async function native(scene, size, spp, ...options) {
  const args = ["render", scene, "--width", size, "--height", size, "--spp", spp, ...options, "-o", join(folder, "native.png")];
  execFileSync(PROGRAM, args.map(String), { cwd: folder, stdio: "pipe" });
  const bytes = await page.evaluate(async () => {
    const blob = await (await fetch("native/native.png", { cache: "no-store" })).blob();
    const bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none" });
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    return [...context.getImageData(0, 0, bitmap.width, bitmap.height).data];
  });
  return Buffer.from(bytes);
}

/** Asserts that two pictures are equal, byte for byte, and show anything. */
function assertEqual(actual, expected, what) {
  assert.equal(actual.length, expected.length, what);
  let [different, most] = [0, 0];
  for (let i = 0; i < actual.length; i++) {
    different += Number(actual[i] !== expected[i]);
    most = Math.max(most, Math.abs(actual[i] - expected[i]));
  }
  assert.equal(different, 0, `${what}: ${different} of ${actual.length} bytes differ, by ${most} at most`);
  assert.ok(new Set(actual).size > 20, `${what}: it is of one colour`);
}

/** Drops files on the page: { name: bytes or text }. */
async function drop(files) {
  const list = Object.entries(files).map(([name, data]) => ({ name, bytes: [...Buffer.from(data)] }));
  await page.evaluate((list) => {
    const transfer = new DataTransfer();
    list.forEach(({ name, bytes }) => transfer.items.add(new File([new Uint8Array(bytes)], name)));
    document.body.dataset.state = "loading";
    document.querySelector("#stage").dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true }));
  }, list);
  await finished();
}

// `build.sh simd` leaves it out.
const hasPlain = existsSync(fileURLToPath(new URL("../dist/page.wasm", import.meta.url)));
const ways = hasPlain ? ["workers=3", "workers=1&simd=no"] : ["workers=3", "workers=1"];

for (const mode of ["path", "ao", "cached"]) {
  test(`${mode}: the picture is the program's, with SIMD${hasPlain ? " and without" : ""}`, async () => {
    for (const more of ways) {
      await visit(`mode=${mode}&size=100&spp=5&${more}`);
      assert.match(await page.textContent("#workers"), more.includes("no") ? /^1, without/ : /^[13], with SIMD/);
      assertEqual(await picture(), await native("cornell", 100, 5, "--integrator", mode), `${mode}, ${more}`);
    }
    assert.match(await page.textContent("#rate"), /^\d+\.\d\d million$/);
    assert.equal(await page.textContent("#samples"), "5 of 5");
  });
}

test("a GLB is dropped on it, and an OBJ with its MTL", async () => {
  await visit("size=64&spp=4&workers=2");
  writeFileSync(join(folder, "tent.glb"), GLB);
  writeFileSync(join(folder, "lamp.obj"), OBJ);
  writeFileSync(join(folder, "lamp.mtl"), MTL);

  await drop({ "tent.glb": GLB });
  assert.match(await page.textContent("#scene"), /^tent\.glb, 2 triangles$/);
  assert.match(await message(), /no light: it stands under a white sky/);
  assertEqual(await picture(), await native("tent.glb", 64, 4, "--sky", 1), "tent.glb");

  await drop({ "lamp.obj": OBJ, "LAMP.MTL": MTL });
  assert.match(await page.textContent("#scene"), /^lamp\.obj, 4 triangles$/);
  assert.equal(await message(), "");
  assertEqual(await picture(), await native("lamp.obj", 64, 4), "lamp.obj");

  await page.click("#cornell");
  await page.waitForFunction(() => document.querySelector("#scene").textContent.startsWith("Cornell"));
  await finished();
  assertEqual(await picture(), await native("cornell", 64, 4), "Cornell box");
});

test("what cannot be read gets a message, and the page goes on", async () => {
  await visit("size=64&spp=4&workers=2");
  const before = await picture();
  const cases = [
    [{ "broken.glb": "this is no model" }, /^broken\.glb: this is not binary glTF/],
    [{ "cut.glb": GLB.subarray(0, GLB.length - 40) }, /^cut\.glb: GLB container: the file is cut short/],
    [{ "bad.obj": "v 0 0 0\nv 1 0 0\nf 1 2 3\n" }, /^bad\.obj:3: vertex 3 does not exist/],
    [{ "empty.ply": "" }, /^empty\.ply: the file is empty/],
    [{ "notes.txt": "hello" }, /^notes\.txt: this is no model/],
  ];
  for (const [files, expected] of cases) {
    await drop(files);
    assert.match(await message(), expected);
    assert.equal(await page.getAttribute("#message", "class"), "error");
    assert.match(await page.textContent("#scene"), /^Cornell box/);
    assertEqual(await picture(), before, Object.keys(files)[0]);
  }
  await page.setInputFiles("#open", [
    { name: "lamp.obj", mimeType: "", buffer: Buffer.from(OBJ) },
  ]);
  await page.waitForFunction(() => document.querySelector("#scene").textContent.startsWith("lamp.obj"));
  await finished();
  assert.match(await message(), /lamp\.mtl.*no such file/);
});

test("a worker that breaks is replaced", async () => {
  const bomb = (script) =>
    script
      .replace("open(files, name) {", 'open(files, name) { if (name === "bomb.obj") { throw new Broken("Bang."); }')
      .replace("start(view, number, count, cache) {", '$& if (view.spp === 16) { throw new Broken("Boom."); }');
  await page.route("**/engine.js", async (route) => {
    const response = await route.fetch();
    await route.fulfill({ response, body: bomb(await response.text()) });
  });
  await visit("size=64&spp=4&workers=2");
  const before = await picture();
  await drop({ "bomb.obj": OBJ });
  assert.equal(await message(), "Bang.");
  assertEqual(await picture(), before, "the scene that was there");

  await page.selectOption("#spp", "16");
  await page.waitForFunction(() => document.body.dataset.state === "failed");
  assert.equal(await message(), "Boom.");
  await page.selectOption("#spp", "64");
  await finished();
  assertEqual(await picture(), await native("cornell", 64, 64), "more samples");
});

test("modes are switched, and records are dots", async () => {
  await visit("size=96&spp=2&workers=2");
  const dots = () =>
    page.evaluate(() => {
      const canvas = document.querySelector("#dots");
      const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
      return data.filter((value, i) => i % 4 === 3 && value > 0).length;
    });
  const pictures = [await picture()];
  assert.equal(await dots(), 0);
  for (const mode of ["ao", "cached", "path"]) {
    await page.check(`input[value=${mode}]`);
    await finished();
    pictures.push(await picture());
    assert.equal((await dots()) > 100, mode === "cached", mode);
    if (mode === "cached") {
      await page.uncheck("#show-records");
      assert.equal(await dots(), 0);
      await page.check("#show-records");
    }
  }
  assertEqual(pictures[3], pictures[0], "path tracing again");
  assert.ok(!pictures[1].equals(pictures[0]) && !pictures[2].equals(pictures[0]) && !pictures[2].equals(pictures[1]));
});

test("mouse and keys go around, and back", async () => {
  await visit("mode=ao&size=64&spp=2&workers=2");
  const first = await picture();
  const box = await page.locator("#picture").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  const moved = async (act) => {
    await act();
    // The picture at rest comes a moment after the hand is off.
    await page.waitForTimeout(400);
    await finished();
    const now = await picture();
    assert.ok(!now.equals(first));
    return now;
  };
  const dragged = await moved(async () => {
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y + 10, { steps: 4 });
    await page.mouse.up();
  });
  const nearer = await moved(() => page.mouse.wheel(0, -100));
  const turned = await moved(() => page.locator("#picture").press("ArrowLeft"));
  assert.ok(!nearer.equals(dragged) && !turned.equals(nearer));
  await page.click("#reset");
  await finished();
  assertEqual(await picture(), first, "after reset");
});

test("the cache is filled anew where a look around interrupts it", async () => {
  await visit("mode=cached&size=64&spp=2&workers=2");
  await page.locator("#picture").press("ArrowLeft");
  await page.click("#reset");
  await page.locator("#picture").press("ArrowRight");
  await page.waitForTimeout(400);
  await finished();
  assert.ok(new Set(await picture()).size > 20);
});

test("it fits on a phone", async () => {
  await page.setViewportSize({ width: 360, height: 740 });
  await visit("size=32&spp=1");
  const [content, window] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
  assert.ok(content <= window, `${content} > ${window}`);
  const { width } = await page.locator("#stage").boundingBox();
  assert.ok(width > 300 && width <= 360, `${width}`);
});
