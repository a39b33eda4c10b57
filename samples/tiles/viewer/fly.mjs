// fly.mjs MODULES TILESET BORDER [PICTURES]: flies in the viewer from far to near over TILESET, a file, with a red
// backdrop, and counts the red pixels inside of BORDER: a JSON list of points in space (glTF's axes) around the surface.
// Exit codes: 0 no hole is seen, and one is where a tile is left out; 1 otherwise; 77 something for it is missing.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { basename, dirname, extname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { draw_all, launch_chromium } from './chromium.mjs';

const [modules, tileset, border_file, pictures] = process.argv.slice(2).map((path) => resolve(path));
const here = dirname(fileURLToPath(import.meta.url));
const kWidth = 640, kHeight = 480;
const browser = await launch_chromium(modules, ['3d-tiles-renderer', 'esbuild', 'three']);
const require = createRequire(join(modules, 'x.js'));
const bundle = require('esbuild').buildSync({
    entryPoints: [join(here, 'viewer.js')], bundle: true, format: 'esm', write: false, nodePaths: [modules],
}).outputFiles[0].contents;

let left_out = '';  // the content that is answered as missing
const kTypes = { '.html': 'text/html', '.js': 'text/javascript', '.json': 'application/json', '.wasm': 'application/wasm' };
const server = createServer((request, response) => {
    const path = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
    try {
        if (left_out && path.endsWith(left_out)) throw new Error('left out');
        const bytes = path === '/viewer.js' ? bundle
            : readFileSync(path === '/index.html' ? join(here, 'index.html')
                : path.startsWith('/draco/') ? join(modules, 'three/examples/jsm/libs', path)
                    : join(dirname(tileset), path.slice('/tileset'.length)));
        response.writeHead(200, { 'content-type': kTypes[extname(path)] ?? 'application/octet-stream' });
        response.end(bytes);
    } catch {
        response.writeHead(404).end();
    }
});
await new Promise((done) => server.listen(0, '127.0.0.1', done));

// In the page: moves the camera.
function move({ at, from }) {
    window.viewer.controls.target.set(...at);
    window.viewer.camera.position.set(...from);
}

// In the page: counts red pixels inside of the border.
function look({ border, size }) {
    const { camera, tiles } = window.viewer;
    const [width, height] = size, outline = new OffscreenCanvas(width, height).getContext('2d');
    outline.beginPath();
    for (const [x, y, z] of border) {
        const p = camera.position.clone().set(x, -z, y).project(camera);
        outline.lineTo(((p.x + 1) / 2) * width, ((1 - p.y) / 2) * height);
    }
    outline.fill('nonzero');
    const mask = outline.getImageData(0, 0, width, height).data;
    const copy = new OffscreenCanvas(width, height).getContext('2d');
    copy.drawImage(document.querySelector('canvas'), 0, 0);
    const seen = copy.getImageData(0, 0, width, height).data;
    let covered = 0, red = 0;
    for (let i = 0; i < seen.length; i += 4) {
        if (mask[i + 3] < 255) continue;
        ++covered;
        if (seen[i] > 150 && seen[i + 1] < 60 && seen[i + 2] < 60) ++red;
    }
    return { covered, red, shown: [...tiles.visibleTiles].map((tile) => tile.content.uri.replace(/.*tiles\//, '')) };
}

const border = JSON.parse(readFileSync(border_file, 'utf8'));
const limits = [0, 1, 2].map((k) => [Math.min(...border.map((p) => p[k])), Math.max(...border.map((p) => p[k]))]);
const [x, y, z] = limits.map(([low, high]) => (low + high) / 2);
const span = limits[0][1] - limits[0][0];
const failures = [], names = new Set();

async function fly(name, views) {
    const page = await browser.newPage({ viewport: { width: kWidth, height: kHeight } });
    page.on('console', (message) => message.type() === 'error' && console.log(`  ${message.text()}`));
    page.on('pageerror', (error) => failures.push(`${name}: ${error}`));
    const { port } = server.address();
    await page.goto(`http://127.0.0.1:${port}/index.html?tileset=tileset/${basename(tileset)}&backdrop=ff0000&error_px=0.5`);
    await page.waitForFunction(() => window.viewer?.tiles.root, null, { timeout: 20000 });
    await page.waitForTimeout(300);
    let reds = 0;
    for (const [k, view] of views.entries()) {
        await page.evaluate(move, view);
        await page.evaluate(draw_all);
        const { covered, red, shown } = await page.evaluate(look, { border, size: [kWidth, kHeight] });
        console.log(`${name} ${k}: ${shown.length} tiles of levels ${[...new Set(shown.map((s) => s[0]))].sort().join(' ')}; ` +
                    `${red} of ${covered} pixels are red`);
        shown.forEach((tile) => names.add(tile));
        if (covered < 50) failures.push(`${name} ${k}: the surface is not in the picture`);
        reds += red;
        if (pictures) {
            mkdirSync(pictures, { recursive: true });
            writeFileSync(join(pictures, `${name}-${k}.png`), await page.screenshot());
        }
    }
    await page.close();
    return reds;
}

// From 40 widths away to two fifths, at an angle that changes on the way, over a corner between tiles.
const views = Array.from({ length: 12 }, (_, k) => {
    const distance = span * 40 * (1 / 100) ** (k / 11), turn = 0.5 * Math.sin(k), at = [x + span * 0.04 * Math.cos(k), -z, y];
    return { at, from: [at[0] + distance * Math.sin(turn), at[1] - distance * Math.cos(turn), at[2] + distance * 0.2] };
});
const holes = await fly('whole', views);
if (holes > 0) failures.push(`${holes} red pixels`);
const levels = new Set([...names].map((name) => name[0]));
if (levels.size < 2) failures.push('the flight shows one level only');
left_out = '/' + [...names].sort().at(-1);
const without = await fly('without one', views.slice(-1));
if (without === 0) failures.push(`no hole is seen where ${left_out} is missing`);
await browser.close();
server.close();
for (const failure of failures) console.log(`FAILED ${failure}`);
process.exit(failures.length > 0 ? 1 : 0);
