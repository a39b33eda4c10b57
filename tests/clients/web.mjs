// web.mjs MODULES SCENES PICTURES CHROMIUM [ONLY]: shows the mesh files of SCENES in headless Chromium with three.js, model-viewer,
// CesiumJS and Babylon.js from MODULES/node_modules, as far as they know the format, and saves a picture of each in PICTURES as
// PROGRAM--FILE.png. Prints one line a file: PROGRAM, VERSION, FILE, and ok or what went wrong, separated by tabs.
import { createServer } from 'node:http';
import { readFile, readdir, mkdir } from 'node:fs/promises';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { extname, join, resolve } from 'node:path';

const [modules, scenes, pictures, browser_path, only = ''] = process.argv.slice(2);
const require = createRequire(resolve(modules, 'package.json'));
const { chromium } = require('playwright-core');
const version = (name) => JSON.parse(readFileSync(join(modules, 'node_modules', name, 'package.json'))).version;

const kHead = `<!doctype html><meta charset="utf-8"><link rel="icon" href="data:,">
<style>html,body{margin:0;background:#335}canvas,#v{width:320px;height:240px}</style>`;
const kDraco = '/m/three/examples/jsm/libs/draco/gltf/';

// Each page shows one file from where its camera stands, and sets window.done to "ok" or a message.
const kThree = kHead + `<script type="importmap">
{"imports":{"three":"/m/three/build/three.module.js","three/addons/":"/m/three/examples/jsm/"}}
</script>
<script type="module">
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { OBJLoader } from 'three/addons/loaders/OBJLoader.js';
import { MTLLoader } from 'three/addons/loaders/MTLLoader.js';
import { PLYLoader } from 'three/addons/loaders/PLYLoader.js';
import { STLLoader } from 'three/addons/loaders/STLLoader.js';
import { USDLoader } from 'three/addons/loaders/USDLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
const file = decodeURIComponent(location.hash.slice(1)), url = '/s/' + encodeURIComponent(file);
async function load() {
    const draco = new DRACOLoader().setDecoderPath('/m/three/examples/jsm/libs/draco/');
    const bare = (geometry, extra = {}) => {
        if (!geometry.attributes.normal) geometry.computeVertexNormals();
        const material = new THREE.MeshStandardMaterial({ side: THREE.DoubleSide, ...extra });
        return { scene: new THREE.Mesh(geometry, material), cameras: [] };
    };
    if (/gl(b|tf)$/.test(file)) return new GLTFLoader().setDRACOLoader(draco).setMeshoptDecoder(MeshoptDecoder).loadAsync(url);
    if (/drc$/.test(file)) return bare(await draco.loadAsync(url));
    if (/ply$/.test(file)) return bare(await new PLYLoader().loadAsync(url), { vertexColors: true });
    if (/stl$/.test(file)) return bare(await new STLLoader().loadAsync(url));
    if (/usdz$/.test(file)) return { scene: await new USDLoader().loadAsync(url), cameras: [] };
    const materials = await new MTLLoader().setPath('/s/').loadAsync(file.replace(/obj$/, 'mtl'));
    materials.preload();
    return { scene: await new OBJLoader().setMaterials(materials).loadAsync(url), cameras: [] };
}
try {
    const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    renderer.setSize(320, 240);
    document.body.append(renderer.domElement);
    const world = new THREE.Scene();
    world.background = new THREE.Color(0x333355);
    world.add(new THREE.HemisphereLight(0xffffff, 0x888888, 3));
    const loaded = await load();
    world.add(loaded.scene);
    const camera = loaded.cameras[0] ?? new THREE.PerspectiveCamera(45, 4 / 3, 0.01, 1000);
    if (/usdz$/.test(file)) {  // stands on its base, not before the camera
        const { center, radius } = new THREE.Box3().setFromObject(loaded.scene).getBoundingSphere(new THREE.Sphere());
        camera.position.copy(center).z += 2 * radius;
    }
    camera.aspect = 4 / 3;
    camera.updateProjectionMatrix();
    await new Promise((done) => setTimeout(done, 300));  // textures decode on their own time
    renderer.render(world, camera);
    let triangles = 0, textures = 0;
    loaded.scene.traverse((o) => { if (o.isMesh) { triangles += (o.geometry.index ?? o.geometry.attributes.position).count / 3;
        textures += [].concat(o.material).filter((m) => m.map ?? m.emissiveMap).length; } });
    window.told = triangles + ' triangles, ' + textures + ' textures, ' + loaded.cameras.length + ' cameras';
    window.done = triangles > 0 ? 'ok' : 'no triangle';
} catch (error) { window.done = String(error); }
</script>`;

const kModelViewer = kHead + `<script>
self.ModelViewerElement = { dracoDecoderLocation: location.origin + '${kDraco}',
    meshoptDecoderLocation: location.origin + '/m/meshoptimizer/meshopt_decoder.js' };
</script>
<script type="module" src="/m/@google/model-viewer/dist/model-viewer.min.js"></script>
<script type="module">
const file = decodeURIComponent(location.hash.slice(1));
await customElements.whenDefined('model-viewer');
const v = document.createElement('model-viewer');
v.id = 'v';
v.style.cssText = 'display:block;background-color:#333355;--progress-bar-height:0px';
// The sample's camera, which model-viewer does not read from the file: it looks along -z with 240 rows at 320 px.
v.setAttribute('camera-orbit', '0deg 90deg 2m');
v.setAttribute('camera-target', '0m 0m -2m');
v.setAttribute('min-camera-orbit', 'auto auto 0m');
v.setAttribute('max-field-of-view', '60deg');
v.setAttribute('field-of-view', 2 * Math.atan(120 / 320) * 180 / Math.PI + 'deg');
v.setAttribute('interpolation-decay', '1');
v.setAttribute('interaction-prompt', 'none');
v.addEventListener('load', () => setTimeout(() => { window.done = 'ok'; }, 800));
v.addEventListener('error', (e) => { window.done = 'error ' + (e.detail?.sourceError ?? e.detail?.type); });
v.src = '/s/' + encodeURIComponent(file);
document.body.append(v);
</script>`;

const kBabylon = kHead + `<canvas id="c" width="320" height="240"></canvas>
<script src="/m/babylonjs/babylon.js"></script><script src="/m/babylonjs-loaders/babylonjs.loaders.min.js"></script>
<script type="module">
const file = decodeURIComponent(location.hash.slice(1));
BABYLON.DracoDecoder.DefaultConfiguration = { wasmUrl: '${kDraco}draco_wasm_wrapper.js',
    wasmBinaryUrl: '${kDraco}draco_decoder.wasm', fallbackUrl: '${kDraco}draco_decoder.js' };
BABYLON.MeshoptCompression.Configuration = { decoder: { url: '/m/meshoptimizer/meshopt_decoder.js' } };
try {
    BABYLON.SceneLoader.ShowLoadingScreen = false;
    const engine = new BABYLON.Engine(document.getElementById('c'), true, { preserveDrawingBuffer: true });
    const scene = new BABYLON.Scene(engine);
    scene.clearColor = new BABYLON.Color4(0.2, 0.2, 0.33, 1);
    await BABYLON.SceneLoader.AppendAsync('/s/', file, scene);
    new BABYLON.HemisphericLight('sky', new BABYLON.Vector3(0, 1, 0.5), scene);
    if (scene.cameras.length > 0) scene.activeCamera = scene.cameras[0];
    else {
        scene.createDefaultCamera(true, true, false);
        scene.activeCamera.alpha += Math.PI;  // it looks at the back, which it does not draw
    }
    await scene.whenReadyAsync();
    for (let i = 0; i < 3; i++) scene.render();
    const triangles = scene.meshes.reduce((sum, mesh) => sum + mesh.getTotalIndices() / 3, 0);
    window.told = triangles + ' triangles, ' + scene.cameras.length + ' cameras';
    window.done = 'ok';
} catch (error) { window.done = String(error); }
</script>`;

const kCesium = kHead + `<canvas id="c" width="320" height="240"></canvas>
<script>window.CESIUM_BASE_URL = '/m/cesium/Build/Cesium/';</script>
<script src="/m/cesium/Build/Cesium/Cesium.js"></script>
<script type="module">
const file = decodeURIComponent(location.hash.slice(1));
try {
    const scene = new Cesium.Scene({ canvas: document.getElementById('c'), creditContainer: document.createElement('div'),
        contextOptions: { webgl: { preserveDrawingBuffer: true } } });
    scene.backgroundColor = Cesium.Color.fromBytes(51, 51, 85);
    scene.highDynamicRange = false;
    const model = await Cesium.Model.fromGltfAsync({ url: '/s/' + encodeURIComponent(file), upAxis: Cesium.Axis.Z,
        forwardAxis: Cesium.Axis.X, backFaceCulling: false });
    scene.primitives.add(model);
    const { camera } = scene;
    camera.position = new Cesium.Cartesian3(0, 0, 0);
    camera.direction = new Cesium.Cartesian3(0, 0, -1);
    camera.up = new Cesium.Cartesian3(0, 1, 0);
    camera.right = new Cesium.Cartesian3(1, 0, 0);
    camera.frustum = new Cesium.PerspectiveFrustum({ fov: 2 * Math.atan(160 / 320), aspectRatio: 4 / 3, near: 0.1, far: 1e4 });
    for (let i = 0, after = 0; i < 800 && after < 20; i++, after += model.ready) {
        scene.render();
        await new Promise((done) => setTimeout(done, 30));
    }
    window.done = model.ready ? 'ok' : 'not ready';
} catch (error) { window.done = String(error); }
</script>`;

const programs = [
    { name: 'three.js', module: 'three', page: kThree, knows: /\.(glb|gltf|drc|obj|ply|stl|usdz)$/ },
    { name: 'model-viewer', module: '@google/model-viewer', page: kModelViewer, knows: /\.(glb|gltf)$/ },
    { name: 'Cesium', module: 'cesium', page: kCesium, knows: /\.(glb|gltf)$/ },
    { name: 'Babylon.js', module: 'babylonjs', page: kBabylon, knows: /\.(glb|gltf|obj|ply|stl)$/ },
];
const kTypes = { '.js': 'text/javascript', '.mjs': 'text/javascript', '.wasm': 'application/wasm', '.html': 'text/html' };

const server = createServer(async (request, response) => {
    const path = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
    const program = programs.find(({ name }) => path === '/' + name);
    try {
        const bytes = program ? program.page
            : await readFile(path.startsWith('/m/') ? join(modules, 'node_modules', path.slice(3)) : join(scenes, path.slice(3)));
        response.writeHead(200, { 'content-type': program ? 'text/html' : kTypes[extname(path)] ?? 'application/octet-stream' });
        response.end(bytes);
    } catch {
        response.writeHead(404).end();
    }
});
await new Promise((done) => server.listen(0, '127.0.0.1', done));
const origin = `http://127.0.0.1:${server.address().port}`;
const browser = await chromium.launch({ executablePath: browser_path,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'] });
await mkdir(pictures, { recursive: true });
const files = (await readdir(scenes)).filter((name) => !/^\.|_texture\.|\.(bin|mtl|json)$/.test(name)).sort();
for (const program of programs.filter(({ name }) => RegExp(only).test(name))) {
    for (const file of files.filter((name) => program.knows.test(name))) {
        const page = await browser.newPage({ viewport: { width: 320, height: 240 } });
        const said = [];
        page.on('console', (message) => { if (message.type() === 'error') said.push(message.text()); });
        page.on('response', (r) => { if (r.status() >= 400) said.push('no ' + r.url()); });
        page.on('pageerror', (error) => said.push(String(error)));
        let result;
        try {
            await page.goto(`${origin}/${program.name}#${encodeURIComponent(file)}`);
            await page.waitForFunction(() => window.done, null, { timeout: 30000 });
            result = await page.evaluate(() => (window.done === 'ok' && window.told ? 'ok: ' + window.told : window.done));
            await page.screenshot({ path: join(pictures, `${program.name}--${file}.png`) });
        } catch (error) {
            result = [String(error).split('\n')[0], ...said].join('; ');
        }
        if (said.length > 0) result += ', said: ' + said.join('; ').slice(0, 200);
        console.log([program.name, version(program.module), file, result.replaceAll(/\s+/g, ' ')].join('\t'));
        await page.close();
    }
}
await browser.close();
server.close();
