// validate.mjs MODULES SCENES: checks the glTF files that the `write_scenes` program wrote into SCENES.
// 1. Khronos' validator reports no error and no warning on any (its notes are printed).
// 2. glTF-Transform, with Draco's own decoder, finds the counts and the positions that expected.json tells.
// Exit codes: 0 all is well, 1 something is wrong, 77 the modules in MODULES are missing (ctest: skipped).
import { readFile, readdir } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [modules, scenes] = process.argv.slice(2).map((path) => resolve(path));
const names = ['gltf-validator', '@gltf-transform/core', '@gltf-transform/extensions', 'draco3dgltf'];
const missing = names.filter((name) => !existsSync(join(modules, 'node_modules', name)));
if (missing.length > 0) {
    console.log(`SKIPPED: no ${missing.join(', ')} in ${modules}/node_modules; run tests/npm-install.sh BUILD_DIR`);
    process.exit(77);
}
const require = createRequire(join(modules, 'package.json'));
const load = (name) => import(pathToFileURL(require.resolve(name)).href);
const validator = require('gltf-validator');
const draco3d = require('draco3dgltf');
const { NodeIO } = await load('@gltf-transform/core');
const { ALL_EXTENSIONS } = await load('@gltf-transform/extensions');

const io = new NodeIO()
    .registerExtensions(ALL_EXTENSIONS)
    .registerDependencies({ 'draco3d.decoder': await draco3d.createDecoderModule() });
const expected = JSON.parse(await readFile(join(scenes, 'expected.json'), 'utf8'));
const problems = [];
const complain = (file, text) => problems.push(`${file}: ${text}`);

async function validate(file, want) {
    const report = await validator.validateBytes(new Uint8Array(await readFile(join(scenes, file))), {
        uri: file,
        maxIssues: 100,
        externalResourceFunction: async (uri) =>
            new Uint8Array(await readFile(join(scenes, decodeURIComponent(uri)))),
    });
    const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
    console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos, ${numHints} hints`);
    for (const { code, message, pointer, severity } of messages) {
        console.log(`  ${['error', 'warning', 'info', 'hint'][severity]} ${code} ${pointer ?? ''}: ${message}`);
    }
    if (report.info.generator !== want.generator) complain(file, `generator is ${report.info.generator}`);
    if (numErrors + numWarnings > 0) complain(file, 'the validator is not content');
}

// Vertices come back in another order from Draco, so each is told by the nearest of the given ones.
function worst_distance(given, found) {
    let worst = 0;
    for (let i = 0; i < found.length; i += 3) {
        let best = Infinity;
        for (let j = 0; j < given.length; j += 3) {
            best = Math.min(best, Math.hypot(found[i] - given[j], found[i + 1] - given[j + 1],
                                             found[i + 2] - given[j + 2]));
        }
        worst = Math.max(worst, best);
    }
    return worst;
}

async function read_back(file, want) {
    const document = await io.read(join(scenes, file));
    const [mesh] = document.getRoot().listMeshes();
    const [primitive] = mesh.listPrimitives();
    const positions = primitive.getAttribute('POSITION');
    const equal = (what, a, b) => a === b || complain(file, `${what} is ${a}, not ${b}`);
    equal('vertices', positions.getCount(), want.vertices);
    equal('triangles', primitive.getIndices().getCount() / 3, want.triangles);
    for (const attribute of primitive.listAttributes()) equal('an attribute', attribute.getCount(), want.vertices);
    equal('texture coordinates', primitive.getAttribute('TEXCOORD_0') !== null, want.textured);
    equal('normals', primitive.getAttribute('NORMAL') !== null, true);
    const material = primitive.getMaterial();
    equal('unlit', material.getExtension('KHR_materials_unlit') !== null, want.textured);
    equal('double sided', material.getDoubleSided(), true);
    const texture = material.getBaseColorTexture();
    equal('a texture', texture !== null, want.textured);
    if (texture) equal('texture size', texture.getSize().join('x'), want.texture_size);

    if (want.positions) {
        const distance = worst_distance(want.positions, positions.getArray());
        console.log(`  ${file}: worst position error ${distance}, allowed ${want.tolerance}`);
        if (!(distance <= want.tolerance)) complain(file, `positions are off by ${distance}`);
    }
}

const files = (await readdir(scenes)).filter((name) => /\.gl(b|tf)$/.test(name)).sort();
if (files.length !== Object.keys(expected).length) complain(scenes, 'holds other files than expected.json tells');
for (const file of files) {
    await validate(file, expected[file]);
    await read_back(file, expected[file]);
}

// The checks themselves must be able to fail.
const broken = await validator.validateString('{"asset": {"version": "2.0"}, "nodes": [{"mesh": 3}]}');
if (broken.issues.numErrors === 0) complain('a broken document', 'passes the validator');

for (const problem of problems) console.log(`FAILED ${problem}`);
console.log(`${files.length} files, ${problems.length} problems`);
process.exit(problems.length > 0 || files.length === 0 ? 1 : 0);
