// Takes the README's picture of the page: node screenshot.mjs FILE.png, after build.sh and test.sh.

import { launch, serve } from "./browser.mjs";

const [server, browser] = await Promise.all([serve("."), launch()]);
const page = await browser.newPage({ viewport: { width: 820, height: 620 } });
await page.goto(`${server.address}?mode=cached&spp=16`);
await page.waitForFunction(() => document.body.dataset.state === "done", null, { timeout: 600_000 });
await page.screenshot({ path: process.argv[2] });
await browser.close();
server.close();
