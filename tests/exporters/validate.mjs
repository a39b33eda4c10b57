// validate.mjs MODULES SCENES: checks the glTF files that the `write_scenes` program wrote into SCENES.
// 1. Khronos' validator reports no error and no warning on any (its notes are printed).
// 2. Bodies are closed, as EXT_mesh_manifold says.
// 3. glTF-Transform, with Draco's own decoder, finds the counts and the positions that expected.json tells.
// Exit codes: 0 all is well, 1 something is wrong, 77 the modules in MODULES are missing (ctest: skipped).
import { readFile, readdir } from 'node:fs/promises';
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [modules, scenes] = process.argv.slice(2).map((path) => resolve(path));
const names = ['gltf-validator', '@gltf-transform/core', '@gltf-transform/extensions', 'draco3dgltf', 'meshoptimizer'];
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

const { MeshoptDecoder } = await load('meshoptimizer');
await MeshoptDecoder.ready;

const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({
    'draco3d.decoder': await draco3d.createDecoderModule(),
    'meshopt.decoder': MeshoptDecoder,
});
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

// A node's matrix, column by column, on a point.
const placed = (m, [x, y, z]) => [0, 1, 2].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r]);

// What a node makes of a normal: the inverse transpose of its scale, which is all that our nodes have.
function turned(scale, [x, y, z]) {
    const n = [x / scale[0], y / scale[1], z / scale[2]];
    const length = Math.hypot(...n);
    return n.map((v) => v / length);
}

// x, y and disparity in px.
const seen = (c, [x, y, z]) => [
    c.cx + (c.focal * x) / -z, c.cy - (c.focal * y) / -z, (c.focal * c.baseline) / -z];

// The number in 0..1 next to a texture coordinate whose last byte is a provenance, as plain files hold it.
function ending_with(coordinate, provenance) {
    const number = new Float32Array([coordinate]), bits = new Uint32Array(number.buffer);
    bits[0] = Math.floor((bits[0] + 0x7f - provenance) / 0x100) * 0x100 + provenance;
    if (number[0] > 1) bits[0] -= 0x100;
    return number[0];
}

const largest = (a, b) => Math.max(...a.map((v, i) => Math.abs(v - b[i])));
const element = (array, width, i) => Array.from(array.slice(i * width, (i + 1) * width));

// Vertices come back in another order, so each is told by the nearest of those given, in the image; then its
// other attributes must be that vertex's.
function compare_vertices(file, want, node, primitive) {
    const positions = primitive.getAttribute('POSITION'), count = positions.getCount();
    const given = Array.from({ length: count }, (_, i) => seen(want.camera, element(want.positions, 3, i)));
    const normals = primitive.getAttribute('NORMAL'), texcoords = primitive.getAttribute('TEXCOORD_0');
    const provenances = primitive.getAttribute('_PROVENANCE');
    const info = primitive.getMaterial().getBaseColorTextureInfo();
    const transform = info?.getExtension('KHR_texture_transform');
    const factor = transform ? transform.getScale() : [1, 1];
    const size = primitive.getMaterial().getBaseColorTexture()?.getSize() ?? want.image;
    const worst = { px: 0, deg: 0, texture_px: 0 }, used = new Set();
    const shift = [];  // of cropped texture coordinates, the same for all vertices
    for (let i = 0; i < count; i++) {
        const at = seen(want.camera, placed(node.getWorldMatrix(), positions.getElement(i, [])));
        let best = 0, error = Infinity;
        for (let j = 0; j < count; j++) {
            const e = largest(at, given[j]);
            if (e < error) [best, error] = [j, e];
        }
        used.add(best);
        worst.px = Math.max(worst.px, error);
        if (normals) {
            const n = turned(node.getScale(), normals.getElement(i, []));
            const w = element(want.normal_values, 3, best);
            // By the chord: an arc cosine loses angles below 0.03 degrees.
            const chord = Math.hypot(...n.map((v, k) => v - w[k] / Math.hypot(...w)));
            worst.deg = Math.max(worst.deg, (2 * Math.asin(chord / 2) * 180) / Math.PI);
        }
        if (texcoords) {
            const t = texcoords.getElement(i, []).map((v, k) => v * factor[k] * size[k]);
            shift.push({ t, w: element(want.texcoord_values, 2, best).map((v, k) => v * want.image[k]), i });
        }
    }
    if (used.size !== count) complain(file, `${count} vertices come back as ${used.size} of those given`);
    // Cropped and scaled: t = (w - corner) * scale; the corner is a whole pixel of the image, the scale the texture's.
    for (const k of texcoords ? [0, 1] : []) {
        const low = shift.reduce((a, b) => (b.w[k] < a.w[k] ? b : a)), high = shift.reduce((a, b) => (b.w[k] > a.w[k] ? b : a));
        const rough = (high.t[k] - low.t[k]) / (high.w[k] - low.w[k]);
        const side = Math.round(size[k] / rough), scale = size[k] / side;
        const corner = Math.round(low.w[k] - low.t[k] / scale);
        if (corner < 0 || corner + side > want.image[k]) complain(file, `the texture is cropped to ${corner}+${side}`);
        const holds_provenance = k === 1 && provenances && texcoords.getArray() instanceof Float32Array;
        for (const { t, w, i } of shift) {
            let right = (w[k] - corner) * scale;
            if (holds_provenance) right = size[k] * ending_with(right / size[k], provenances.getScalar(i));
            worst.texture_px = Math.max(worst.texture_px, Math.abs(t[k] - right));
        }
    }
    console.log(`  ${file}: worst ${worst.px.toFixed(5)} px, ${worst.deg.toFixed(4)} deg, ` +
                `${worst.texture_px.toFixed(5)} texture px; allowed ${want.tolerance_px}, ${want.tolerance_deg}`);
    if (!(worst.px <= want.tolerance_px)) complain(file, `positions are off by ${worst.px} px`);
    if (!(worst.deg <= want.tolerance_deg)) complain(file, `normals are off by ${worst.deg} degrees`);
    if (!(worst.texture_px <= Math.max(want.tolerance_px, 1e-4)))
        complain(file, `texture coordinates are off by ${worst.texture_px} px`);
}

// The nodes behind the scene's one are its coarser levels, in the order in which MSFT_lod names them.
function read_levels(file, want, document) {
    const nodes = document.getRoot().listNodes().filter((node) => node.getMesh());
    if (nodes.length !== 1 + want.levels.length) complain(file, `${nodes.length} nodes for ${want.levels.length} coarser levels`);
    const primitives = nodes.map((node) => node.getMesh().listPrimitives()[0]);
    // All levels show one surface: the camera sees nearly the same width of each.
    const spans = primitives.map((primitive, k) => {
        const positions = primitive.getAttribute('POSITION'), xs = [];
        for (let i = 0; i < positions.getCount(); i++)
            xs.push(seen(want.camera, placed(nodes[k].getWorldMatrix(), positions.getElement(i, [])))[0]);
        return xs.reduce((a, b) => Math.max(a, b)) - xs.reduce((a, b) => Math.min(a, b));
    });
    want.levels.forEach((vertices, i) => {
        const level = primitives[i + 1];
        if (level.getAttribute('POSITION').getCount() !== vertices) complain(file, `level ${i + 1} has other vertices`);
        if (level.getMaterial() !== primitives[0].getMaterial()) complain(file, `level ${i + 1} has another material`);
        if (Math.abs(spans[i + 1] / spans[0] - 1) > 0.1) complain(file, `level ${i + 1} spans ${spans[i + 1]} px, not ${spans[0]}`);
    });
}

// The document as written: glTF-Transform knows neither MSFT_lod nor EXT_mesh_manifold.
async function as_written(file) {
    const bytes = await readFile(join(scenes, file));
    return JSON.parse(file.endsWith('.glb') ? bytes.subarray(20, 20 + bytes.readUInt32LE(12)) : bytes);
}

// A body is closed, and says so of the accessors that it draws: each edge runs once in each direction.
async function check_body(file, primitive) {
    const { extensionsUsed, extensionsRequired, meshes: [mesh] } = await as_written(file);
    const [drawn] = mesh.primitives, said = mesh.extensions?.EXT_mesh_manifold?.manifoldPrimitive;
    if (!extensionsUsed?.includes('EXT_mesh_manifold')) complain(file, 'does not say that it uses EXT_mesh_manifold');
    if (extensionsRequired?.includes('EXT_mesh_manifold')) complain(file, 'requires EXT_mesh_manifold');
    if (said?.indices !== drawn.indices || said?.attributes.POSITION !== drawn.attributes.POSITION)
        complain(file, 'is a body of other accessors than those drawn');
    const corners = primitive.getIndices().getArray(), edges = new Set();
    const ends = (i) => [corners[i], corners[i % 3 === 2 ? i - 2 : i + 1]];
    for (let i = 0; i < corners.length; i++) edges.add(ends(i).join());
    if (edges.size !== corners.length) complain(file, `${corners.length - edges.size} edges run twice in one direction`);
    for (let i = 0; i < corners.length; i++)
        if (!edges.has(ends(i).reverse().join())) return complain(file, `the edge ${ends(i)} is open`);
}

async function lod_links(file) {
    const json = await as_written(file);
    const [node] = json.nodes;
    return { ids: node.extensions?.MSFT_lod?.ids ?? [], coverage: node.extras?.MSFT_screencoverage ?? [],
        roots: json.scenes[0].nodes };
}

async function read_back(file, want) {
    const document = await io.read(join(scenes, file));
    const node = document.getRoot().getDefaultScene().listChildren()[0];
    const [primitive] = node.getMesh().listPrimitives();
    const positions = primitive.getAttribute('POSITION');
    const equal = (what, a, b) => a === b || complain(file, `${what} is ${a}, not ${b}`);
    equal('vertices', positions.getCount(), want.vertices);
    equal('triangles', primitive.getIndices().getCount() / 3, want.triangles);
    for (const attribute of primitive.listAttributes()) equal('an attribute', attribute.getCount(), want.vertices);
    equal('texture coordinates', primitive.getAttribute('TEXCOORD_0') !== null, want.texcoords);
    equal('normals', primitive.getAttribute('NORMAL') !== null, want.normals);
    const material = primitive.getMaterial();
    const kind = want.textured ? ['emissive', 'unlit', 'lit'][want.material] : 'lit';
    equal('unlit', material.getExtension('KHR_materials_unlit') !== null, kind === 'unlit');
    equal('emission', material.getEmissiveFactor().join(), kind === 'emissive' ? '1,1,1' : '0,0,0');
    equal('an emissive texture', material.getEmissiveTexture(), kind === 'emissive' ? material.getBaseColorTexture() : null);
    equal('double sided', material.getDoubleSided(), true);
    const texture = material.getBaseColorTexture();
    equal('a texture', texture !== null, want.textured);
    const { ids, coverage, roots } = await lod_links(file);
    equal('levels', ids.join(), want.levels.map((_, i) => i + 1).join());
    equal('screen coverages', coverage.length, want.levels.length > 0 ? want.levels.length + 1 : 0);
    if (want.body) return check_body(file, primitive);
    equal('roots', roots.join(), `0,${1 + want.levels.length}`);  // the finest level and the camera
    const camera = document.getRoot().listCameras()[0];
    equal('aspect ratio', camera?.getAspectRatio(), 4 / 3);
    const used = document.getRoot().listExtensionsUsed().map((e) => e.extensionName);
    for (const name of want.extensions) equal(`use of ${name}`, used.includes(name), true);
    read_levels(file, want, document);
    if (want.positions) compare_vertices(file, want, node, primitive);
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
