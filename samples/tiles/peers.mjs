// A solved map beside other programs' meshes of it with as many triangles: how far each lies from the map, and how long it took.
//
// usage, in a folder where `npm install delatin @mapbox/martini` was run:
//   node peers.mjs MAP.pfm SCENE.glb FOCAL_PX BASELINE_M
// SCENE.glb is what `hexrelief tiles merge` wrote of MAP.pfm with this camera, not compressed. delatin is hmm's algorithm, greedy
// insertion (Garland & Heckbert 1995), martini a tree of right triangles, for maps of 2^n + 1 px a side. Both want a height
// everywhere: unknown pixels take the farther of their row's nearest known disparities. Errors are those of known pixels, in px of
// disparity.
import { readFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

function readPfm(path) {
    const bytes = readFileSync(path);
    const [head, width, height, scale] = /^Pf\s+(\d+)\s+(\d+)\s+(\S+)\s/.exec(bytes.toString('latin1', 0, 100)) ?? [];
    if (!head || scale > 0) throw new Error(`${path} is no grey PFM, little endian`);
    const values = new Float32Array(width * height);
    for (let y = 0; y < height; ++y)  // the file's first row is the lowest
        for (let x = 0; x < width; ++x) {
            const value = bytes.readFloatLE(head.length + 4 * ((height - 1 - y) * width + x));
            values[y * width + x] = Number.isFinite(value) && value > 0 ? value : 0;
        }
    return { width: +width, height: +height, values };
}

function filled({ width, height, values }) {
    const out = values.slice();
    for (let y = 0; y < height; ++y) {
        const row = out.subarray(y * width, (y + 1) * width);
        for (let x = 0, left = 0; x < width;) {
            if (row[x] > 0) { left = row[x++]; continue; }
            let end = x;
            while (end < width && !(row[end] > 0)) ++end;
            const right = end < width ? row[end] : 0;
            row.fill(left && right ? Math.min(left, right) : left || right, x, end);
            x = end;
        }
    }
    return out;
}

// Corners as x, y, disparity in px, three a triangle.
function cornersOfGlb(path, map, focal, baseline) {
    const bytes = readFileSync(path), jsonBytes = bytes.readUInt32LE(12);
    const gltf = JSON.parse(bytes.toString('utf8', 20, 20 + jsonBytes)), start = 28 + jsonBytes;
    const array = (index, type, components) => {
        const { bufferView, byteOffset = 0, count } = gltf.accessors[index], view = gltf.bufferViews[bufferView];
        const at = start + (view.byteOffset ?? 0) + byteOffset, size = count * components * type.BYTES_PER_ELEMENT;
        return new type(bytes.buffer.slice(bytes.byteOffset + at, bytes.byteOffset + at + size));
    };
    const kinds = { 5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array }, corners = [];
    for (const { mesh, translation = [0, 0, 0] } of gltf.nodes) {
        if (mesh === undefined) continue;
        for (const { attributes, indices } of gltf.meshes[mesh].primitives) {
            const p = array(attributes.POSITION, Float32Array, 3);
            const own = array(indices, kinds[gltf.accessors[indices].componentType], 1), part = new Float64Array(3 * own.length);
            own.forEach((v, k) => {
                const [x, y, z] = [0, 1, 2].map((axis) => p[3 * v + axis] + translation[axis]);
                part.set([map.width / 2 - focal * x / z, map.height / 2 + focal * y / z, -focal * baseline / z], 3 * k);
            });
            corners.push(part);
        }
    }
    return corners;
}

function cornersOfGrid(heights, width, coords, triangles) {
    const part = new Float64Array(3 * triangles.length);
    triangles.forEach((v, k) => {
        const x = coords[2 * v], y = coords[2 * v + 1];
        part.set([x + 0.5, y + 0.5, heights[y * width + x]], 3 * k);
    });
    return [part];
}

// The nearest surface at each pixel's centre.
function rasterised({ width, height }, parts) {
    const kSlack = 1e-6, seen = new Float32Array(width * height);
    for (const c of parts)
        for (let t = 0; t < c.length; t += 9) {
            const [ax, ay, ad, bx, by, bd, cx, cy, cd] = c.subarray(t, t + 9);
            const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
            if (Math.abs(area) < 1e-12) continue;
            const low = (...v) => Math.max(0, Math.ceil(Math.min(...v) - 0.5 - kSlack));
            const high = (size, ...v) => Math.min(size - 1, Math.floor(Math.max(...v) - 0.5 + kSlack));
            for (let y = low(ay, by, cy); y <= high(height, ay, by, cy); ++y)
                for (let x = low(ax, bx, cx); x <= high(width, ax, bx, cx); ++x) {
                    const px = x + 0.5, py = y + 0.5;
                    const u = ((bx - px) * (cy - py) - (by - py) * (cx - px)) / area;
                    const v = ((cx - px) * (ay - py) - (cy - py) * (ax - px)) / area;
                    if (u < -kSlack || v < -kSlack || u + v > 1 + kSlack) continue;
                    const d = u * ad + v * bd + (1 - u - v) * cd, i = y * width + x;
                    if (d > seen[i]) seen[i] = d;
                }
        }
    return seen;
}

function report(name, map, parts, seconds) {
    const seen = rasterised(map, parts);
    let known = 0, covered = 0, squares = 0, sum = 0, far = 0;
    map.values.forEach((d, i) => {
        if (!(d > 0)) return;
        ++known;
        if (!(seen[i] > 0)) return;
        const error = Math.abs(seen[i] - d);
        ++covered;
        squares += error * error;
        sum += error;
        far += error > 1;
    });
    const triangles = parts.reduce((count, part) => count + part.length / 9, 0);
    const cells = [name, triangles, seconds?.toFixed(1) ?? '', Math.sqrt(squares / covered).toFixed(3), (sum / covered).toFixed(3),
        `${(100 * far / covered).toFixed(3)} %`, `${(100 * covered / known).toFixed(2)} %`];
    console.log(`| ${cells.join(' | ')} |`);
    return triangles;
}

const [input, scene, focal, baseline] = process.argv.slice(2);
if (baseline === undefined) {
    console.error('usage: node peers.mjs MAP.pfm SCENE.glb FOCAL_PX BASELINE_M');
    process.exit(2);
}
const load = async (name) => (await import(pathToFileURL(resolve(`node_modules/${name}/index.js`)))).default;
const [Delatin, Martini] = [await load('delatin'), await load('@mapbox/martini')];
const map = readPfm(input), heights = filled(map), { width, height } = map;
console.log('| | triangles | s | root mean square | mean | above 1 px | covered |\n| --- | --- | --- | --- | --- | --- | --- |');
const wanted = report('hexrelief', map, cornersOfGlb(scene, map, +focal, +baseline));

let begun = performance.now();
const tin = new Delatin(heights, width, height);
while (tin.triangles.length < 3 * wanted) tin.refine();
report('delatin', map, cornersOfGrid(heights, width, tin.coords, tin.triangles), (performance.now() - begun) / 1000);

if (width === height && Number.isInteger(Math.log2(width - 1))) {
    begun = performance.now();
    const tile = new Martini(width).createTile(heights);
    let low = 0, high = 1000;  // most triangles, none
    for (let k = 0; k < 30; ++k) {
        const middle = (low + high) / 2;
        if (tile.getMesh(middle).triangles.length > 3 * wanted) low = middle; else high = middle;
    }
    const seconds = (performance.now() - begun) / 1000, mesh = tile.getMesh(high);
    report('martini', map, cornersOfGrid(heights, width, mesh.vertices, mesh.triangles), seconds);
}
