// A disparity map simplified by meshoptimizer 1.x, as files that `rd.py --peer` compares with.
//
// usage, in a folder where `npm install meshoptimizer` was run:
//   node simplify_map.mjs MAP.pfm BACKGROUND_PX STEP_PX OUT TRIANGLES...
// Takes the grid of all pixels from BACKGROUND_PX on without triangles across steps of more than STEP_PX, simplifies it to each of
// these numbers of triangles and writes OUT_TRIANGLES.obj: x, y, disparity in px. MAP.pfm may be the disparity.pfm that
// `hexrelief run --save-stages` writes. Near surfaces count more: an attribute that grows with disparity^2.5 says so.
import { readFileSync, writeFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

function readPfm(path) {
    const bytes = readFileSync(path);
    const [head, width, height, scale] = /^Pf\s+(\d+)\s+(\d+)\s+(\S+)\s/.exec(bytes.toString('latin1', 0, 100)) ?? [];
    if (!head) throw new Error(`${path} is no grey PFM`);
    const values = new Float32Array(width * height);
    for (let y = 0; y < height; ++y)  // the file's first row is the lowest
        for (let x = 0; x < width; ++x) {
            const at = head.length + 4 * ((height - 1 - y) * width + x);
            const value = scale < 0 ? bytes.readFloatLE(at) : bytes.readFloatBE(at);
            values[y * width + x] = Number.isFinite(value) && value > 0 ? value : 0;
        }
    return { width: +width, height: +height, values };
}

// Unknown pixels take the farther of their row's nearest known disparities, as the uniform grid of rd.py does.
function filled({ width, height, values }) {
    const out = values.slice();
    for (let y = 0; y < height; ++y) {
        const row = values.subarray(y * width, (y + 1) * width);
        row.forEach((value, x) => {
            if (value > 0) return;
            const left = row.subarray(0, x).findLast((v) => v > 0), right = row.subarray(x).find((v) => v > 0);
            out[y * width + x] = left && right ? Math.min(left, right) : left ?? right ?? 0;
        });
    }
    return out;
}

// A vertex in each pixel's centre, and a ring of them half a pixel outside of the image, so that it is covered to its edge.
function gridOf(map, background, step) {
    const { width, height } = map, values = filled(map);
    const columns = width + 2, rows = height + 2, positions = new Float32Array(3 * columns * rows);
    const pixel = new Int32Array(columns * rows), indices = [];
    const inside = (at, size) => Math.min(Math.max(at - 1, 0), size - 1);
    for (let i = 0; i < pixel.length; ++i) {
        const x = i % columns, y = Math.floor(i / columns);
        pixel[i] = inside(y, height) * width + inside(x, width);
        positions.set([x - 0.5, y - 0.5, values[pixel[i]]], 3 * i);
    }
    const add = (...corners) => {
        const disparities = corners.map((i) => values[pixel[i]]);
        const isSeen = corners.some((i) => map.values[pixel[i]] > 0 && map.values[pixel[i]] >= background);
        if (isSeen && Math.max(...disparities) - Math.min(...disparities) <= step) indices.push(...corners);
    };
    for (let y = 0; y + 1 < rows; ++y)
        for (let x = 0; x + 1 < columns; ++x) {
            const a = y * columns + x, b = a + columns;
            add(a, b, a + 1);
            add(a + 1, b, b + 1);
        }
    return { positions, indices: Uint32Array.from(indices) };
}

function simplified(simplifier, grid, size, triangles) {
    const positions = grid.positions.slice(), indices = grid.indices.slice();
    const disparities = positions.filter((_, i) => i % 3 === 2), nearest = disparities.reduce((a, b) => Math.max(a, b), 0);
    const near = disparities.map((value) => nearest * (value / nearest) ** 2.5);
    const [count] = simplifier.simplifyWithUpdate(
        indices, positions, 3, near, 1, [0.4 / size], null, 3 * triangles, 1);
    return { positions, indices: indices.slice(0, count) };
}

function writeObj(path, { positions, indices }, simplifier) {
    const [index, used] = simplifier.compactMesh(indices);  // renumbers `indices`
    const lines = new Array(used);
    index.forEach((to, from) => {
        if (to < used) lines[to] = `v ${[...positions.subarray(3 * from, 3 * from + 3)].map((v) => +v.toFixed(4)).join(' ')}`;
    });
    for (let i = 0; i < indices.length; i += 3)
        lines.push(`f ${indices[i] + 1} ${indices[i + 1] + 1} ${indices[i + 2] + 1}`);
    writeFileSync(path, lines.join('\n') + '\n');
}

const [input, background, step, out, ...counts] = process.argv.slice(2);
if (counts.length === 0) {
    console.error('usage: node simplify_map.mjs MAP.pfm BACKGROUND_PX STEP_PX OUT TRIANGLES...');
    process.exit(2);
}
const { MeshoptSimplifier } = await import(pathToFileURL(resolve('node_modules/meshoptimizer/index.js')));
await MeshoptSimplifier.ready;
const map = readPfm(input), grid = gridOf(map, +background, +step), size = Math.max(map.width, map.height);
for (const count of counts)
    writeObj(`${out}_${count}.obj`, simplified(MeshoptSimplifier, grid, size, +count), MeshoptSimplifier);
