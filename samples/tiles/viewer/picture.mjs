// picture.mjs MODULES ADDRESS PICTURE: what headless Chromium shows of the page at ADDRESS, as a PNG.
// Exit codes: 0 it shows a tile; 1 it does not, or the page has errors; 77 something for it is missing.
import { resolve } from 'node:path';
import { draw_all, launch_chromium } from './chromium.mjs';

const [modules, address, picture] = process.argv.slice(2);
const browser = await launch_chromium(resolve(modules), []);
const page = await browser.newPage({ viewport: { width: 1280, height: 960 } });
const failures = [];
page.on('pageerror', (error) => failures.push(error));
page.on('requestfailed', (request) => failures.push(`${request.url()}: ${request.failure().errorText}`));
page.on('response', (answer) => answer.status() >= 400 && failures.push(`${answer.url()}: ${answer.status()}`));
await page.goto(address);
await page.waitForFunction(() => window.viewer?.tiles.root, null, { timeout: 20000 });
await page.evaluate(draw_all);
const shown = await page.evaluate(() => window.viewer.tiles.visibleTiles.size);
await page.screenshot({ path: picture });
await browser.close();
if (shown === 0) failures.push('no tile is shown');
for (const failure of failures) console.log(`FAILED ${failure}`);
if (failures.length === 0) console.log(`${picture}: ${shown} tiles`);
process.exit(failures.length > 0 ? 1 : 0);
