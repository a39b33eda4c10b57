// Shows the tileset that the address names: index.html?tileset=URL. &backdrop=ff0000 is what shows through holes.
import { AmbientLight, Color, DirectionalLight, PerspectiveCamera, Scene, Sphere, WebGLRenderer } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { TilesRenderer } from '3d-tiles-renderer';
import { GLTFExtensionsPlugin, ImplicitTilingPlugin } from '3d-tiles-renderer/plugins';

const options = new URLSearchParams(location.search);
const renderer = new WebGLRenderer({ preserveDrawingBuffer: true });
document.body.append(renderer.domElement);
const scene = new Scene();
scene.background = new Color(`#${options.get('backdrop') ?? '202028'}`);
const sun = new DirectionalLight(0xffffff, 2);
sun.position.set(-1, -2, 2);
scene.add(sun, new AmbientLight(0xffffff, 1));

// A tileset's z is up; the relief is seen along y by the camera that took it, which stood at the origin.
const camera = new PerspectiveCamera(50, 1, 0.01, 1e5);
camera.up.set(0, 0, 1);
const controls = new OrbitControls(camera, renderer.domElement);
const tiles = new TilesRenderer(new URL(options.get('tileset') ?? 'tileset.json', document.baseURI).href);
tiles.errorTarget = Number(options.get('error_px') ?? 4);
tiles.registerPlugin(new ImplicitTilingPlugin());
tiles.registerPlugin(new GLTFExtensionsPlugin({
    dracoLoader: new DRACOLoader().setDecoderPath('draco/'),
    meshoptDecoder: MeshoptDecoder,
}));
tiles.setCamera(camera);
scene.add(tiles.group);

function look_at_all() {
    const sphere = new Sphere();
    if (!tiles.getBoundingSphere(sphere)) return;
    const { center, radius } = sphere;
    controls.target.copy(center);
    camera.position.set(center.x, center.y - radius / Math.tan((camera.fov * Math.PI) / 360), center.z);
}
function resize() {
    renderer.setPixelRatio(devicePixelRatio);
    renderer.setSize(innerWidth, innerHeight);
    camera.aspect = innerWidth / innerHeight;
    tiles.setResolutionFromRenderer(camera, renderer);
}
function draw() {
    controls.update();
    camera.near = Math.max(1e-3, camera.position.distanceTo(controls.target) / 1000);
    camera.far = camera.near * 1e5;
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    tiles.update();
    renderer.render(scene, camera);
}

tiles.addEventListener('load-root-tileset', look_at_all);
addEventListener('resize', resize);
resize();
renderer.setAnimationLoop(draw);
window.viewer = { camera, controls, draw, tiles };
