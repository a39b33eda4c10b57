// tileset.mjs MODULES TILESET.json IMPLICIT.json: another implementation of 3D Tiles 1.1, 3d-tiles-tools, walks the explicit and
// the implicit form of a tileset. Both lead to the same files; each file lies in the box of its tile, and that in the box of the
// tile above; errors fall from level to level. Prints how many files there are; exit code 1 where anything is wrong.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';

const [modules, ...tilesets] = process.argv.slice(2).map((path) => resolve(path));
const { TilesetTraverser, TilesetSources, TilesetSourceResourceResolver, BoundingVolumesContainment } =
    createRequire(join(modules, 'package.json'))('3d-tiles-tools');
let failures = 0;
const check = (holds, message) => {
    if (holds) return;
    console.log(`FAILED ${message}`);
    ++failures;
};

const corners = ([low, high]) =>
    [...Array(8).keys()].map((k) => [0, 1, 2].map((axis) => (k >> axis & 1 ? high : low)[axis]));
const box_corners = (box) =>
    [...Array(8).keys()].map((k) => [0, 1, 2].map((axis) => box[axis] +
        [0, 1, 2].reduce((sum, half) => sum + (k >> half & 1 ? 1 : -1) * box[3 * half + 3 + axis], 0)));

// The corners of the box around a GLB's positions, in a tileset's axes, of which z is up; what lies around a translated node.
const content_corners = (path) => {
    const bytes = readFileSync(path);
    check(bytes.toString('latin1', 0, 4) === 'glTF', `${path} is no GLB`);
    const gltf = JSON.parse(bytes.toString('utf8', 20, 20 + bytes.readUInt32LE(12)));
    const points = [];
    for (const { mesh, translation = [0, 0, 0], scale = [1, 1, 1] } of gltf.nodes ?? [])
        for (const { attributes } of gltf.meshes[mesh]?.primitives ?? []) {
            const { min, max } = gltf.accessors[attributes.POSITION];
            points.push(...corners([min, max]).map((point) => point.map((v, k) => v * scale[k] + translation[k])));
        }
    check(points.length > 0, `${path} holds no mesh`);
    return points.map(([x, y, z]) => [x, -z, y]);
};
const inside = (box, points) => points.every((point) => BoundingVolumesContainment.contains({ box }, point, 1e-3));

const files_of = async (path) => {
    const source = await TilesetSources.createAndOpen(dirname(path));
    const traverser = new TilesetTraverser('.', new TilesetSourceResourceResolver('.', source));
    const files = new Map();
    await traverser.traverse(JSON.parse(readFileSync(path)), async (traversed) => {
        const { boundingVolume, geometricError } = traversed.asFinalTile();
        const above = traversed.getParent()?.asFinalTile();
        if (above) {
            check(geometricError <= above.geometricError, `${path}: ${traversed.path}: a larger error than above`);
            check(inside(above.boundingVolume.box, box_corners(boundingVolume.box)),
                  `${path}: ${traversed.path}: not within the tile above`);
        }
        if (traversed.isImplicitTilesetRoot()) return true;  // whose content is a pattern of names
        for (const { uri } of traversed.getFinalContents()) {
            files.set(uri, geometricError);
            check(inside(boundingVolume.box, content_corners(join(dirname(path), uri))),
                  `${path}: ${uri}: positions outside of its tile`);
        }
        return true;
    });
    await source.close();
    return files;
};

const [explicit, implicit] = [await files_of(tilesets[0]), await files_of(tilesets[1])];
check(explicit.size > 0, 'no file at all');
check(explicit.size === implicit.size && [...explicit.keys()].every((uri) => implicit.has(uri)),
      `${explicit.size} files by the explicit form, ${implicit.size} by the implicit one`);
console.log(`${explicit.size} files, levels' errors ${[...new Set(explicit.values())].sort((a, b) => b - a).slice(0, 5)}`);
process.exit(failures > 0 ? 1 : 0);
