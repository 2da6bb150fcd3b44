// Runs under `node --test`: the page of a moving scene in a browser shows what Node.js makes with the package.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";

import { launch, serve } from "../browser.mjs";
import { createScene } from "../npm/index.js";
import { RINGS, World } from "./world.js";

const [WIDTH, HEIGHT] = [96, 72];
let browser, server;

before(async () => {
  [browser, server] = await Promise.all([launch(), serve(".")]);
});

after(async () => {
  await browser?.close();
  server?.close();
});

/** What the page shows at a time. */
async function shown(time, more = "") {
  const page = await browser.newPage();
  const errors = [];
  page.on("pageerror", (error) => errors.push(error.message));
  await page.goto(`${server.address}moving/?width=${WIDTH}&height=${HEIGHT}&time=${time}${more}`);
  await page.waitForFunction(() => document.body.dataset.state !== undefined, null, { timeout: 60_000 });
  assert.deepEqual([await page.getAttribute("body", "data-state"), errors], ["done", []], await page.textContent("#message"));
  const bytes = await page.evaluate(() => {
    const canvas = document.querySelector("#picture");
    return [...canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data];
  });
  const scene = await page.textContent("#rings");
  await page.close();
  return { bytes, scene };
}

test("the page shows the scene at its time, with SIMD and without", async () => {
  const world = new World(await createScene());
  const pictures = [];
  for (const time of [0.5, 2]) {
    world.move(time);
    const expected = [...world.picture(WIDTH, HEIGHT).bytes];
    pictures.push(expected);
    for (const [more, simd] of [["", "with"], ["&simd=no", "without"]]) {
      const { bytes, scene } = await shown(time, more);
      assert.equal(scene, `${RINGS} moving rings of 576 triangles, ${simd} SIMD`);
      // Sines and powers are the engines' own, and may differ in the last place; the hits do not.
      const different = bytes.filter((byte, i) => Math.abs(byte - expected[i]) > 1).length;
      assert.ok(different <= 8, `${different} bytes differ`);
    }
  }
  const moved = pictures[0].filter((byte, i) => byte !== pictures[1][i]).length;
  assert.ok(moved > 0.05 * pictures[0].length, `${moved} of ${pictures[0].length} bytes have changed`);
});
