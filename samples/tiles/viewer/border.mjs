// border.mjs FOLDER: the longest closed line around the surface in a plan's solved tiles, as fly.mjs takes it: points in space in
// glTF's axes, as JSON. A twentieth of the way inside: from the side, high things on the rim lie over what is beside them.
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';

const folder = process.argv[2], kInside = 0.05, kPlacesPerPixel = 1024;
const plan = JSON.parse(readFileSync(join(folder, 'plan.json'), 'utf8'));
const levels = readdirSync(join(folder, 'tiles')).map(Number);
const finest = join(folder, 'tiles', String(Math.max(...levels)));

// Edges of triangles that no other triangle has, in any tile, by the corner that they begin at.
const after = new Map(), corners = new Map();
for (const column of readdirSync(finest))
    for (const name of readdirSync(join(finest, column)).filter((name) => name.endsWith('.mesh'))) {
        const bytes = readFileSync(join(finest, column, name));
        let at = 8;  // behind the magic number and the kind
        const next_array = (bytes_of_one, read) => {
            const count = Number(bytes.readBigUInt64LE(at)), first = at + 8;
            at = first + count * bytes_of_one;
            return Array.from({ length: count }, (_, k) => read(first + k * bytes_of_one));
        };
        const corner = (from) => [bytes.readInt32LE(from), bytes.readInt32LE(from + 4), bytes.readFloatLE(from + 8)];
        const own = next_array(12, corner), names = own.map(String);
        const triangles = next_array(12, (from) => [0, 4, 8].map((k) => bytes.readUInt32LE(from + k)));
        const edges = new Set();
        for (const t of triangles) for (const k of [0, 1, 2]) edges.add(`${names[t[k]]} ${names[t[(k + 1) % 3]]}`);
        for (const pair of next_array(24, (from) => [corner(from), corner(from + 12)])) edges.delete(pair.map(String).join(' '));
        for (const edge of edges) {
            const [a, b] = edge.split(' ');
            if (!edges.has(`${b} ${a}`)) after.set(a, [...(after.get(a) ?? []), b]);
        }
        own.forEach((c, k) => corners.set(names[k], c));
    }

const lines = [];
while (after.size > 0) {
    const line = [after.keys().next().value];
    for (let here = line[0]; ; line.push(here)) {
        const ways = after.get(here);
        if (!ways) break;
        if (ways.length === 1) after.delete(here);
        here = ways.pop();
        if (here === line[0]) break;
    }
    lines.push(line);
}
const border = lines.reduce((a, b) => (b.length > a.length ? b : a)).map((name) => corners.get(name));
const middle = [0, 1].map((k) => border.reduce((sum, c) => sum + c[k], 0) / border.length);
const { focal_px, cx, cy, baseline_m, doffs_px } = plan.calibration;
const points = border.map(([x, y, disparity]) => {
    const depth = (focal_px * baseline_m) / (disparity + doffs_px);
    const px = [x, y].map((v, k) => (v + kInside * (middle[k] - v)) / kPlacesPerPixel);
    return [((px[0] - cx) * depth) / focal_px, (-(px[1] - cy) * depth) / focal_px, -depth];
});
console.log(JSON.stringify(points));
