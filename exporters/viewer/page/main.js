import { WebGLRenderer } from 'three';
import { OrbitCamera } from './camera.js';
import { listen } from './gestures.js';
import { readGlb, writePlainGlb } from './glb.js';
import { kLooks } from './materials.js';
import { Measure } from './measure.js';
import { rounded, showFigures, showLevels, showPictures, showScale } from './panel.js';
import { makeTexture, Relief } from './relief.js';

const kWiggle_rad = 0.06;
const kWiggle_s = 3.2;
const kGreetings = 2; // times that the relief sways after the page is opened

const byId = (id) => document.getElementById(id);
const say = (text) => { byId('status').textContent = text ?? ''; };

function decodeBase64(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

function save(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

function saveMesh(glb, name) {
  save(new Blob([glb], { type: 'model/gltf-binary' }), `${name}.glb`);
}

// The page without its view: the picture of the relief, and why there is no more.
function giveUp(reason) {
  byId('controls').hidden = true;
  byId('view').hidden = true;
  byId('problem').textContent = `The relief cannot be turned here: ${reason}`;
  byId('problem').hidden = false;
  document.body.dataset.state = 'failed';
}

// Null where there is no WebGL 2.
function makeRenderer() {
  const canvas = byId('view');
  const context = canvas.getContext('webgl2', { antialias: true, alpha: true });
  return context && new WebGLRenderer({ canvas, context });
}

class Viewer {
  constructor(facts, renderer, relief) {
    this.facts = facts;
    this.renderer = renderer;
    this.relief = relief;
    this.orbit = new OrbitCamera(facts.camera, relief.depth);
    this.measure = new Measure(relief);
    this.isMeasuring = false;
    this.wiggleSince = null;
    this.colour();
  }

  // The page's colours, which follow the system's light or dark.
  colour() {
    const style = getComputedStyle(document.documentElement);
    const to = (colour, name) => colour.setStyle(style.getPropertyValue(name).trim(), '');
    to(this.relief.wire.uniforms.colour.value, '--wire');
    to(this.relief.hatch.uniforms.dark.value, '--hatch-dark');
    to(this.relief.hatch.uniforms.light.value, '--hatch-light');
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = byId('view');
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.relief.hatch.uniforms.size.value = 6 * window.devicePixelRatio;
    this.orbit.fit(width, height);
    this.draw();
  }

  draw() {
    this.orbit.update(this.relief.sphere);
    this.relief.wire.uniforms.height.value = byId('view').height;
    this.renderer.render(this.relief.scene, this.orbit.camera);
  }

  // At the next frame, once, however often it is asked for until then.
  redraw() {
    if (this.pending) return;
    this.pending = requestAnimationFrame((now) => {
      this.pending = null;
      if (this.wiggleSince !== null) {
        if (now - this.wiggleSince > this.wiggleEnds_ms) return this.wiggle(false);
        this.orbit.sway = kWiggle_rad * Math.sin(((now - this.wiggleSince) / 1000 / kWiggle_s) * 2 * Math.PI);
        this.redraw();
      }
      this.draw();
    });
  }

  wiggle(on, times = Infinity) {
    this.wiggleSince = on ? performance.now() : null;
    this.wiggleEnds_ms = times * kWiggle_s * 1000;
    this.orbit.sway = 0;
    byId('wiggle').ariaPressed = String(on);
    this.redraw();
  }

  // Shows at first sight that this is no picture. The first touch ends it.
  greet() {
    if (matchMedia('(prefers-reduced-motion: reduce)').matches) return;
    this.wiggle(true, kGreetings);
    const touched = new AbortController();
    const end = () => {
      touched.abort();
      if (this.wiggleSince !== null && this.wiggleEnds_ms < Infinity) this.wiggle(false);
    };
    for (const kind of ['pointerdown', 'wheel', 'keydown'])
      window.addEventListener(kind, end, { signal: touched.signal, capture: true, passive: true });
  }

  back() {
    this.wiggle(false);
    this.orbit.reset();
    this.redraw();
  }

  setMeasuring(on) {
    this.isMeasuring = on;
    this.measure.clear();
    byId('measure').ariaPressed = String(on);
    document.body.classList.toggle('measuring', on);
    say(on ? 'Click two points of the relief' : '');
    if (on) this.setLift(1);
    this.redraw();
  }

  // x, y: px of the view.
  click(x, y) {
    if (!this.isMeasuring) return;
    const { clientWidth: width, clientHeight: height } = byId('view');
    const problem = this.measure.take((2 * x) / width - 1, 1 - (2 * y) / height, this.orbit.camera, window.devicePixelRatio);
    const { distance } = this.measure;
    const unit = this.facts.camera.metric ? 'm' : 'units; the pair is not calibrated';
    say(problem ?? (distance === null ? 'Now the second point' : `Distance: ${rounded(distance)} ${unit}`));
    this.redraw();
  }

  setLook(look) {
    this.relief.setLook(look);
    byId('scale').hidden = look !== 'depth';
    document.querySelector(`input[value=${look}]`).checked = true;
    this.redraw();
  }

  // The relief's lines stay on its rays, so measuring needs it where it was measured.
  setLift(lift) {
    this.relief.setLift(lift);
    byId('lift').value = String(Math.round(100 * lift));
    byId('flat').checked = lift === 0;
    if (lift < 1 && this.isMeasuring) this.setMeasuring(false);
    this.redraw();
  }

  setWireframe(shown) {
    this.relief.setWireframe(shown);
    byId('wireframe').checked = shown;
    this.redraw();
  }

  setLevel(level) {
    this.relief.setLevel(level);
    this.measure.clear();
    showFigures(this.facts, level);
    this.redraw();
  }

  savePicture() {
    this.draw(); // the picture is only there until the browser has shown it
    byId('view').toBlob((blob) => save(blob, `${this.facts.name}.png`), 'image/png');
  }

  toggleFullscreen() {
    if (document.fullscreenElement) document.exitFullscreen();
    else document.documentElement.requestFullscreen?.().catch(() => say('Full screen is not allowed here'));
  }

  togglePanel() {
    const isBare = document.body.classList.toggle('bare');
    byId('panel').textContent = isBare ? 'Show panel' : 'Hide panel';
    byId('panel').ariaExpanded = String(!isBare);
    this.resize();
  }
}

function listenToControls(viewer, glb) {
  const redraw = () => viewer.redraw();
  listen(byId('view'), viewer.orbit, redraw, (x, y) => viewer.click(x, y));
  for (const input of document.querySelectorAll('input[name=look]'))
    input.addEventListener('change', () => viewer.setLook(input.value));
  const onChange = (id, action) => byId(id).addEventListener('input', (event) => action(event.target));
  onChange('wireframe', (box) => viewer.setWireframe(box.checked));
  onChange('flat', (box) => {
    viewer.setLift(box.checked ? 0 : 1);
    if (box.checked) viewer.setWireframe(true);
  });
  onChange('holes', (box) => { viewer.relief.wall.visible = box.checked; redraw(); });
  byId('guesses-label').hidden = !viewer.relief.hasGuesses;
  onChange('guesses', (box) => { viewer.relief.setGuesses(box.checked); redraw(); });
  onChange('lift', (slider) => viewer.setLift(slider.value / 100));
  onChange('level', (list) => viewer.setLevel(Number(list.value)));

  const actions = {
    back: () => viewer.back(),
    wiggle: () => viewer.wiggle(viewer.wiggleSince === null),
    measure: () => viewer.setMeasuring(!viewer.isMeasuring),
    fullscreen: () => viewer.toggleFullscreen(),
    picture: () => viewer.savePicture(),
    panel: () => viewer.togglePanel(),
    'mesh-file': () => saveMesh(writePlainGlb(glb), viewer.facts.name),
    'small-mesh-file': () => saveMesh(glb, viewer.facts.name),
  };
  for (const [id, action] of Object.entries(actions)) byId(id).addEventListener('click', action);
  listenToKeys(viewer, actions);

  new ResizeObserver(() => viewer.resize()).observe(byId('view'));
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { viewer.colour(); redraw(); });
}

function listenToKeys(viewer, actions) {
  const keys = {
    p: actions.back, w: actions.wiggle, m: actions.measure, f: actions.fullscreen, s: actions.picture,
    h: actions.panel,
    escape: () => { viewer.wiggle(false); viewer.setMeasuring(false); },
  };
  kLooks.forEach((look, i) => {
    keys[i + 1] = () => { if (!document.querySelector(`input[value=${look}]`).disabled) viewer.setLook(look); };
  });
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.matches('select')) return;
    keys[event.key.toLowerCase()]?.();
  });
  byId('view').addEventListener('keydown', (event) => {
    const { clientWidth, clientHeight } = byId('view');
    if (event.key === 'Enter') viewer.click(clientWidth / 2, clientHeight / 2);
  });
}

async function start() {
  const facts = JSON.parse(byId('facts').textContent);
  const poster = facts.pictures.find(({ name }) => name === 'relief');
  if (poster) {
    byId('poster').src = poster.source;
    byId('poster').hidden = false;
  }
  byId('generator').textContent = facts.generator;
  showFigures(facts, 0);
  showLevels(facts);
  showPictures(facts.pictures);
  performance.mark('panel');
  const renderer = makeRenderer();
  performance.mark('renderer');
  if (!renderer) return giveUp('this browser has no WebGL 2, or it is switched off.');
  byId('view').addEventListener('webglcontextlost', () => giveUp('the graphics card gave up; load the page again.'));
  const glb = decodeBase64(byId('glb').textContent);
  const { levels, image } = readGlb(glb);
  performance.mark('mesh');
  const relief = new Relief(levels, image && (await makeTexture(image, renderer)), facts.camera);
  performance.mark('relief');
  const viewer = new Viewer(facts, renderer, relief);
  showScale(relief.inverse, facts.camera);
  document.querySelector('input[value=photograph]').disabled = !image;
  viewer.setLook(relief.look);
  listenToControls(viewer, glb);
  viewer.resize();
  byId('poster').hidden = true;
  document.body.dataset.state = 'ready';
  performance.mark('ready');
  viewer.greet();
  return viewer;
}

start().catch((error) => giveUp(error.message));
