// validate_tiles.mjs MODULES PROGRAM WORK: Khronos' validator finds no error and no warning in any GLB of a merged tileset, without
// compression and with Draco. Exit codes: 0 all is well, 1 something is wrong, 77 the validator is not in MODULES (ctest: skipped).
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';

const [modules, program, work] = process.argv.slice(2).map((path) => resolve(path));
if (!existsSync(join(modules, 'node_modules/gltf-validator'))) {
    console.log(`SKIPPED: no gltf-validator in ${modules}/node_modules; run tests/npm-install.sh BUILD_DIR`);
    process.exit(77);
}
const validator = createRequire(join(modules, 'package.json'))('gltf-validator');
const tiles = (...words) => execFileSync(program, ['tiles', ...words]);
const problems_of = async (bytes) => {
    const { numErrors, numWarnings, messages } = (await validator.validateBytes(new Uint8Array(bytes))).issues;
    return numErrors + numWarnings > 0 ? messages.filter(({ severity }) => severity < 2) : [];
};

rmSync(work, { recursive: true, force: true });
mkdirSync(work, { recursive: true });
// Hills with buildings, and a lake that is unknown.
const [width, height, map] = [720, 600, join(work, 'map.pfm')];
const disparities = Float32Array.from({ length: width * height }, (_, i) => {
    const [x, y] = [i % width, Math.floor(i / width)];
    if (Math.hypot(x - 500, y - 200) < 60) return Infinity;
    return 60 + 20 * Math.sin(x / 90) * Math.cos(y / 70) + (x % 96 < 40 && y % 96 < 50 ? 25 : 0);
});
writeFileSync(map, Buffer.concat([Buffer.from(`Pf\n${width} ${height}\n-1.0\n`), Buffer.from(disparities.buffer)]));
let failures = 0;
for (const compression of ['none', 'draco']) {
    const plan = join(work, compression);
    tiles('plan', map, '-o', plan, '--tile-vertices', '80', '--quiet', '--set', 'mesh.spacing_px=3',
          '--set', 'input.calibration.focal_px=720', '--set', 'input.calibration.baseline_m=0.5',
          '--set', `export.compression=${compression}`);
    tiles('solve', plan, '--quiet');
    tiles('merge', plan, '-o', join(plan, 'tileset.json'), '--quiet');
    tiles('merge', plan, '-o', join(plan, 'scene.glb'), '--quiet');
    const files = readdirSync(plan, { recursive: true }).filter((name) => name.endsWith('.glb'));
    for (const name of files)
        for (const { code, pointer, message } of await problems_of(readFileSync(join(plan, name)))) {
            console.log(`FAILED ${compression}/${name}: ${code} ${pointer ?? ''}: ${message}`);
            ++failures;
        }
    console.log(`${compression}: ${files.length} files`);
    if (files.length < 10) failures = 1;  // 3 x 2 tiles, 2 and 1 of coarser levels, one of all
}
const broken = Buffer.from('{"asset": {"version": "2.0"}, "nodes": [{"mesh": 3}]}');
if ((await problems_of(broken)).length === 0) failures = 1;  // the check itself must be able to fail
rmSync(work, { recursive: true });
process.exit(failures > 0 ? 1 : 0);
