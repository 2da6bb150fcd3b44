// Loads baked files in headless Chromium and looks at the pixels.
//
// A furnace by hand: a wall whose lightmap has two known texels. Then, if `HALFDOME` names the program, a room that it
// bakes: three.js must show what `halfdome render` does. Last, cube maps that it makes, by the lookup that it prints.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { createReadStream, existsSync, mkdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';
import { lookUp } from './cubes.mjs';
import { furnace, room } from './levels.mjs';

const here = fileURLToPath(new URL('.', import.meta.url));
const out = join(here, 'out');
mkdirSync(out, { recursive: true });
const [width, height] = [320, 240];

/// A server of this folder's files; gives its address.
async function serve() {
    const types = { '.html': 'text/html', '.js': 'text/javascript', '.gltf': 'model/gltf+json' };
    const server = createServer((request, response) => {
        const path = join(here, normalize(decodeURIComponent(new URL(request.url, 'http://a').pathname)));
        if (!existsSync(path) || !statSync(path).isFile()) return response.writeHead(404).end();
        response.writeHead(200, { 'content-type': types[extname(path)] ?? 'application/octet-stream' });
        createReadStream(path).pipe(response);
    });
    await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
    return { server, address: `http://127.0.0.1:${server.address().port}` };
}

/// The sRGB codes of a picture in the browser: of the canvas, or of the PNG at `url`.
const codes = (page, url) => page.evaluate(async (url) => {
    const canvas = document.createElement('canvas');
    const source = url ? await createImageBitmap(await (await fetch(url)).blob()) : document.querySelector('canvas');
    [canvas.width, canvas.height] = [source.width, source.height];
    const context = canvas.getContext('2d');
    context.drawImage(source, 0, 0);
    return Array.from(context.getImageData(0, 0, canvas.width, canvas.height).data);
}, url);

async function shown(page, address, file) {
    await page.goto(`${address}/index.html?size=${width}x${height}&file=out/${encodeURIComponent(file)}`);
    await page.evaluate(() => window.shown);
    return codes(page);
}

const { server, address } = await serve();
const webgpu = ['--enable-unsafe-webgpu', '--use-webgpu-adapter=swiftshader'];
const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', ...webgpu],
});
try {
    const page = await browser.newPage({ viewport: { width, height } });
    const failures = [];
    page.on('pageerror', (error) => failures.push(error.message));

    // An albedo of one half under 2 pi and under pi / 2 W/m²: radiance 1 and 1/4, codes 255 and 137.
    const { gltf, hdr } = furnace();
    writeFileSync(join(out, 'furnace.gltf'), JSON.stringify(gltf));
    writeFileSync(join(out, 'light map.hdr'), hdr);
    const wall = await shown(page, address, 'furnace.gltf');
    const at = (x, y) => wall.slice(4 * (y * width + x), 4 * (y * width + x) + 3);
    const near = (found, code) => found.every((value) => Math.abs(value - code) <= 1);
    assert(near(at(20, 120), 255), `the left is ${at(20, 120)}`);
    assert(near(at(300, 120), 137), `the right is ${at(300, 120)}`);
    console.log('furnace: the pixels have the right values');

    const halfdome = process.env.HALFDOME;
    if (halfdome === undefined) {
        console.log('room: skipped, as HALFDOME names no program');
    } else {
        const run = (...words) => execFileSync(halfdome, words, { cwd: out, stdio: ['ignore', 'ignore', 'inherit'] });
        writeFileSync(join(out, 'room.gltf'), JSON.stringify(room()));
        run('bake', 'room.gltf', '-o', 'room.baked.gltf', '--preset', 'three', '--density', '24');
        run('render', 'room.gltf', '-o', 'room.png', '--width', `${width}`, '--height', `${height}`, '--spp', '1024');
        const three = await shown(page, address, 'room.baked.gltf');
        await page.screenshot({ path: join(out, 'three.png') });
        const native = await codes(page, `${address}/out/room.png`);
        const differences = three.map((code, i) => Math.abs(code - native[i])).filter((_, i) => i % 4 < 3);
        const mean = differences.reduce((a, b) => a + b) / differences.length;
        const sorted = differences.toSorted((a, b) => a - b);
        const most = sorted[Math.floor(0.95 * sorted.length)];
        console.log(`room: ${mean.toFixed(2)} codes apart on average, 95% within ${most}`);
        assert(mean < 2.5 && most <= 8);
        await lookUp(run, out, page);
    }
    assert.deepEqual(failures, []);
} finally {
    await browser.close();
    server.close();
}
