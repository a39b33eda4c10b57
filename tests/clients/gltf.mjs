// gltf.mjs MODULES SCENES: Khronos' validator and glTF-Transform on the glTF files of SCENES. Prints lines as web.mjs does.
import { readFile, readdir } from 'node:fs/promises';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [modules, scenes] = process.argv.slice(2).map((path) => resolve(path));
const require = createRequire(join(modules, 'package.json'));
const load = (name) => import(pathToFileURL(require.resolve(name)).href);
const version = (name) => JSON.parse(readFileSync(join(modules, 'node_modules', name, 'package.json'))).version;
const validator = require('gltf-validator');
const { NodeIO, Logger } = await load('@gltf-transform/core');
const { ALL_EXTENSIONS } = await load('@gltf-transform/extensions');
const { MeshoptDecoder } = await load('meshoptimizer');
await MeshoptDecoder.ready;
const io = new NodeIO().setLogger(new Logger(Logger.Verbosity.SILENT)).registerExtensions(ALL_EXTENSIONS).registerDependencies({
    'draco3d.decoder': await require('draco3dgltf').createDecoderModule(), 'meshopt.decoder': MeshoptDecoder });

async function validate(file) {
    const { issues } = await validator.validateBytes(new Uint8Array(await readFile(join(scenes, file))), { uri: file,
        externalResourceFunction: async (uri) => new Uint8Array(await readFile(join(scenes, decodeURIComponent(uri)))) });
    const counts = `${issues.numErrors} errors, ${issues.numWarnings} warnings`;
    return issues.numErrors + issues.numWarnings === 0 ? 'ok: ' + counts : counts;
}

async function transform(file) {
    const root = (await io.read(join(scenes, file))).getRoot();
    const triangles = root.listMeshes().flatMap((mesh) => mesh.listPrimitives())
        .reduce((sum, primitive) => sum + primitive.getIndices().getCount() / 3, 0);
    return `ok: ${triangles} triangles, ${root.listTextures().length} textures, ${root.listCameras().length} cameras`;
}

const files = (await readdir(scenes)).filter((name) => /\.gl(b|tf)$/.test(name)).sort();
const programs = [['gltf-validator', 'gltf-validator', validate], ['glTF-Transform', '@gltf-transform/core', transform]];
for (const [name, module, check] of programs)
    for (const file of files)
        console.log([name, version(module), file, await check(file).catch((error) => String(error))].join('\t'));
