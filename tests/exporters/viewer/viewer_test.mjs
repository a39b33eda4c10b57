// viewer_test.mjs MODULES PROGRAM SAMPLES: the page of the sample pair, in Chromium.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { differences, launch, open, pixels, settle, shot } from './browser.mjs';

const [modules, program, samples] = process.argv.slice(2);
const kName = "a <script>document.title = 'ran'<b> & \"b\"";
const kWidth = 320, kHeight = 240; // of the sample pair; the principal point is put elsewhere than in its middle

const folder = mkdtempSync(join(tmpdir(), 'hexrelief-viewer-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));
const file = join(folder, `${kName}.html`);
try {
  const camera = ['focal_px=320', 'baseline_m=0.16', 'cx=190', 'cy=100'].flatMap((key) => ['--set', `input.calibration.${key}`]);
  execFileSync(program, ['run', '--disparity', join(samples, 'disparity.pfm'), '--color', join(samples, 'left.png'), ...camera,
    '-o', file, '--set', 'export.lod=2', '--quiet'], { stdio: 'pipe' });
} catch (error) {
  const said = String(error.stderr);
  if (!said.includes('without its viewer')) throw error;
  console.log(`SKIPPED: ${said}`);
  process.exit(77);
}

const browser = await launch(modules);
const { page, complaints } = await open(browser, file, { viewport: { width: kWidth, height: kHeight } });
let failures = 0;

async function check(name, test) {
  const begun = Date.now();
  try {
    const note = await test();
    console.log(`ok   ${name}${note ? `: ${note}` : ''} (${Date.now() - begun} ms)`);
  } catch (error) {
    ++failures;
    console.log(`FAIL ${name}: ${error.stack}`);
  }
}

// What is changed, as a share of the pixels for which `where` is true.
function changedShare(a, b, where, least = 3) {
  const difference = differences(a, b);
  let all = 0, changed = 0;
  for (let i = 0; i < difference.length; ++i) {
    if (!where(i)) continue;
    ++all;
    if (difference[i] >= least) ++changed;
  }
  return changed / all;
}

async function savedPicture() {
  const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('s')]);
  return { name: download.suggestedFilename(), picture: await pixels(page, readFileSync(await download.path())) };
}

const setSwitch = (id, on) => page.evaluate(([box, to]) => {
  const element = document.getElementById(box);
  if (element.checked !== to) element.click();
}, [id, on]);

const setValue = (id, value) => page.evaluate(([control, to]) => {
  const element = document.getElementById(control);
  element.value = to;
  element.dispatchEvent(new Event('input'));
}, [id, value]);

assert.equal(await page.evaluate(() => document.body.dataset.state), 'ready');
await page.keyboard.press('h'); // without the panel the view has the photograph's size
await page.evaluate(() => {
  document.getElementById('view').style.outline = 'none';
  document.getElementById('panel').style.opacity = 0; // it lies on the view
});
await setSwitch('holes', false);
await settle(page);
const { name: savedName, picture: saved } = await savedPicture();
const alpha = (i) => saved.data[4 * i + 3];
const covered = (i) => alpha(i) === 255;
// Away from the relief's edges, where pixels are mixed.
const neighbours = (i) => [1, kWidth - 1, kWidth, kWidth + 1, 2, 2 * kWidth]
  .flatMap((step) => [i - step, i + step])
  .filter((n) => n >= 0 && n < kWidth * kHeight);
const inside = (i) => covered(i) && neighbours(i).every(covered);
const outside = (i) => alpha(i) === 0 && neighbours(i).every((n) => alpha(n) === 0);
const first = await shot(page);

await check('the first frame is the photograph', async () => {
  const photograph = await pixels(page, readFileSync(join(samples, 'left.png')));
  const sums = [0, 0, 0];
  let count = 0;
  for (let i = 0; i < kWidth * kHeight; ++i) {
    if (!inside(i)) continue;
    ++count;
    for (let c = 0; c < 3; ++c) sums[c] += Math.abs(first.data[4 * i + c] - photograph.data[4 * i + c]);
  }
  const means = sums.map((sum) => sum / count);
  assert.ok(count > 0.5 * kWidth * kHeight, `${count} pixels are covered`);
  assert.ok(means.every((mean) => mean < 3), `differences of ${means}`);
  return `mean difference ${means.map((mean) => mean.toFixed(2)).join(', ')} of 255 on ${count} pixels`;
});

await check('the picture is saved under the name of the page', async () => {
  assert.equal([saved.width, saved.height].join(), [kWidth, kHeight].join());
  assert.match(savedName, /\.png$/);
});

await check('a name that looks like a script stays text', async () => {
  assert.equal(await page.title(), kName);
  assert.equal(await page.textContent('h1'), kName);
  assert.equal(await page.evaluate(() => document.scripts.length), 3);
});

await check('the policy stops what is not the page’s own', async () => {
  const ran = await page.evaluate(() => {
    const script = document.createElement('script');
    script.textContent = 'window.ran = true';
    document.body.append(script);
    script.remove();
    return window.ran;
  });
  assert.equal(ran, undefined);
  assert.match(complaints.pop(), /Content Security Policy/);
});

for (const [key, look] of [['2', 'lit grey'], ['3', 'depth'], ['4', 'normals']])
  await check(`${look} changes the surface alone`, async () => {
    await page.keyboard.press(key);
    const now = await shot(page);
    await page.keyboard.press('1');
    assert.ok(changedShare(first, now, inside) > 0.95);
    assert.equal(changedShare(first, now, outside), 0);
  });

await check('the photograph comes back', async () => assert.equal(changedShare(first, await shot(page), () => true), 0));

await check('the wireframe is lines on the surface', async () => {
  await setSwitch('wireframe', true);
  const now = await shot(page);
  await setSwitch('wireframe', false);
  const share = changedShare(first, now, inside);
  assert.ok(share > 0.1 && share < 0.9, `${share} of the surface changed`);
  // Triangles thinner than a pixel are seen as lines alone.
  assert.ok(changedShare(first, now, outside) < 0.002);
});

await check('where triangles are small their lines are fainter', async () => {
  await page.keyboard.press('2');
  const bare = await shot(page);
  await setSwitch('wireframe', true);
  const difference = differences(bare, await shot(page)), kSide = 20; // px, of blocks that hold triangles of any size
  await setSwitch('wireframe', false);
  await page.keyboard.press('1');
  let most = 0;
  for (let top = 0; top + kSide <= kHeight; top += kSide)
    for (let left = 0; left + kSide <= kWidth; left += kSide) {
      const block = [...Array(kSide ** 2).keys()].map((i) => (top + Math.floor(i / kSide)) * kWidth + left + (i % kSide));
      if (block.every(inside)) most = Math.max(most, block.reduce((sum, i) => sum + difference[i], 0) / block.length);
    }
  assert.ok(most > 20 && most < 64, `a block is changed by ${most}`);
});

await check('holes are hatched, and nothing else', async () => {
  await setSwitch('holes', true);
  const now = await shot(page);
  await setSwitch('holes', false);
  assert.equal(changedShare(first, now, inside), 0);
  assert.ok(changedShare(first, now, outside) > 0.95);
});

await check('the flat lattice looks the same from the camera, and not from elsewhere', async () => {
  await setValue('lift', 0);
  const changed = changedShare(first, await shot(page), inside, 8);
  assert.ok(changed < 0.01, `${changed} of the surface changed`);
  await page.keyboard.press('p');
  await page.focus('#view');
  await page.keyboard.press('ArrowLeft');
  const flat = await shot(page);
  await setValue('lift', 100);
  assert.ok(changedShare(flat, await shot(page), () => true, 8) > 0.2);
  await page.keyboard.press('p');
});

await check('mouse, wheel and keys move the view, and P brings the photograph back', async () => {
  const moves = {
    drag: async () => {
      await page.mouse.move(160, 120);
      await page.mouse.down();
      await page.mouse.move(200, 140, { steps: 3 });
      await page.mouse.up();
    },
    pan: async () => {
      await page.mouse.move(160, 120);
      await page.mouse.down({ button: 'right' });
      await page.mouse.move(200, 140, { steps: 3 });
      await page.mouse.up({ button: 'right' });
    },
    wheel: async () => {
      await page.mouse.move(160, 120);
      await page.mouse.wheel(0, -240);
      await page.waitForTimeout(50);
    },
    arrow: () => page.keyboard.press('ArrowUp'),
    'shift and arrow': () => page.keyboard.press('Shift+ArrowRight'),
    plus: () => page.keyboard.press('+'),
    wiggle: async () => {
      await page.keyboard.press('w');
      await page.waitForTimeout(200);
    },
  };
  await page.focus('#view');
  const png = async () => {
    await settle(page);
    return page.screenshot();
  };
  const before = await png();
  for (const [name, move] of Object.entries(moves)) {
    await move();
    assert.ok(!before.equals(await png()), name);
    await page.keyboard.press('p');
    assert.ok(before.equals(await png()), `after ${name}`);
  }
});

await check('levels of detail change the mesh', async () => {
  const rows = () => page.textContent('#figures');
  const fine = await rows();
  assert.equal(await page.locator('#level option').count(), 2);
  await setSwitch('wireframe', true);
  const before = await shot(page);
  await setValue('level', 1);
  assert.ok(changedShare(before, await shot(page), inside) > 0.05);
  assert.notEqual(await rows(), fine);
  await setValue('level', 0);
  await setSwitch('wireframe', false);
});

// Points of the exact disparity map in metres: bottom row first after a header of three lines.
function pointAt(x, y) {
  const bytes = readFileSync(join(samples, 'disparity.pfm'));
  const values = bytes.subarray(bytes.length - kWidth * kHeight * 4);
  const disparity = values.readFloatLE(((kHeight - 1 - y) * kWidth + x) * 4);
  const { focal_px: focal, baseline_m: baseline, cx, cy } = camera;
  const depth = (focal * baseline) / disparity;
  return [((x + 0.5 - cx) * depth) / focal, ((y + 0.5 - cy) * depth) / focal, depth];
}

const { camera } = await page.evaluate(() => JSON.parse(document.getElementById('facts').textContent));

await check('the distance between two clicks is that of the map', async () => {
  await page.evaluate(() => document.getElementById('measure').click());
  for (const [x, y] of [[40, 100], [190, 170]]) await page.mouse.click(x + 0.5, y + 0.5);
  const said = await page.textContent('#status');
  const [a, b] = [pointAt(40, 100), pointAt(190, 170)];
  const wanted = Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  const got = Number(said.match(/Distance: ([\d.]+) m/)?.[1]);
  assert.ok(Math.abs(got - wanted) < 0.02 * wanted, `${said}, wanted ${wanted} m`);
  await page.keyboard.press('Escape');
  return `${got} m of ${wanted.toFixed(3)} m`;
});

await check('fingers turn, pinch and move the view', async () => {
  const devtools = await page.context().newCDPSession(page);
  const touch = (type, ...points) => devtools.send('Input.dispatchTouchEvent', {
    type, touchPoints: points.map(([x, y], id) => ({ x, y, id })),
  });
  const before = await shot(page);
  await touch('touchStart', [100, 100]);
  for (let x = 104; x < 160; x += 8) await touch('touchMove', [x, 110]);
  await touch('touchEnd');
  const turned = await shot(page);
  assert.ok(changedShare(before, turned, () => true, 8) > 0.2, 'turned');
  await page.keyboard.press('p');
  await touch('touchStart', [140, 100], [180, 100]);
  for (let d = 2; d < 60; d += 8) await touch('touchMove', [140 - d, 100], [180 + d, 100]);
  await touch('touchEnd');
  assert.ok(changedShare(before, await shot(page), () => true, 8) > 0.2, 'pinched');
  await page.keyboard.press('p');
  assert.equal(changedShare(before, await shot(page), () => true), 0);
});

await check('the keyboard alone reaches everything', async () => {
  await page.keyboard.press('h'); // the panel is back
  await page.evaluate(() => document.activeElement.blur());
  const reached = new Set();
  for (let i = 0; i < 28; ++i) {
    await page.keyboard.press('Tab');
    reached.add(await page.evaluate(() => {
      const { id, name, tagName } = document.activeElement;
      return id || name || tagName;
    }));
  }
  const wanted = ['view', 'back', 'wiggle', 'measure', 'look', 'wireframe', 'flat', 'holes', 'lift', 'level', 'fullscreen',
    'picture', 'mesh-file', 'small-mesh-file', 'panel', 'SUMMARY'];
  assert.deepEqual(wanted.filter((id) => !reached.has(id)), []);
  await page.focus('#view');
  await page.keyboard.press('m');
  await page.keyboard.press('Enter');
  await page.keyboard.press('ArrowLeft');
  await page.keyboard.press('Enter');
  assert.match(await page.textContent('#status'), /Distance: /);
  await page.keyboard.press('Escape');
  await page.keyboard.press('p');
});

await check('the mesh is saved as a GLB that needs no extension', async () => {
  const [download] = await Promise.all(
    [page.waitForEvent('download'), page.evaluate(() => document.getElementById('mesh-file').click())]);
  const glb = readFileSync(await download.path());
  assert.equal(glb.readUInt32LE(8), glb.length);
  const json = JSON.parse(glb.subarray(20, 20 + glb.readUInt32LE(12)).toString());
  assert.equal(json.extensionsRequired, undefined);
  const [{ attributes, indices }] = json.meshes[0].primitives;
  const { levels } = await page.evaluate(() => JSON.parse(document.getElementById('facts').textContent));
  assert.equal(json.accessors[indices].count, 3 * levels[0].triangles);
  assert.equal(json.accessors[attributes.POSITION].count, levels[0].vertices);
  assert.equal(json.images.length, 1);
  assert.equal(json.nodes[1].camera, 0);
  assert.equal(json.cameras.length, 1);
});

await check('the relief sways at first sight, until it is touched', async () => {
  const { page: swaying } = await open(browser, file, { reducedMotion: 'no-preference' });
  const isPressed = () => swaying.getAttribute('#wiggle', 'aria-pressed');
  assert.equal(await isPressed(), 'true');
  await swaying.mouse.click(60, 60);
  assert.equal(await isPressed(), 'false');
  await swaying.context().close();
});

await check('everything has a name, and nothing is wider than 360 px', async () => {
  await page.setViewportSize({ width: 360, height: 640 });
  const unnamed = await page.evaluate(() => [...document.querySelectorAll('button, input, select, canvas, img:not([hidden])')]
    .filter((each) => !(each.ariaLabel || each.alt || each.labels?.length || each.textContent.trim())).map((each) => each.id));
  assert.deepEqual(unnamed, []);
  const widths = await page.evaluate(() => [document.documentElement, document.querySelector('aside')]
    .map((each) => each.scrollWidth - each.clientWidth));
  assert.deepEqual(widths, [0, 0]);
});

await check('nothing is logged, nothing is asked for', async () => assert.deepEqual(complaints, []));

await check('what no camera saw is shown and left open', async () => {
  assert.ok(await page.locator('#guesses-label').isHidden()); // the sample's background is removed: nothing continues
  const whole = join(folder, 'whole.html');
  execFileSync(program, ['run', '--disparity', join(samples, 'disparity.pfm'), '--color', join(samples, 'left.png'),
    '--set', 'density.background.method=none', '-o', whole, '--quiet'], { stdio: 'pipe' });
  const other = await open(browser, whole, { viewport: { width: 900, height: 500 } });
  assert.ok(await other.page.locator('#guesses-label').isVisible());
  const view = other.page.locator('#view');
  const picture = async () => { await settle(other.page); return pixels(other.page, await view.screenshot()); };
  const set = async (shown) => { await other.page.setChecked('#guesses', shown); return picture(); };
  const share = (a, b) => changedShare(a, b, () => true);
  const before = await picture();
  assert.ok(share(before, await set(false)) < 0.002, 'nothing of it is seen from the left camera');
  await other.page.focus('#view');
  for (let i = 0; i < 8; ++i) await other.page.keyboard.press('ArrowLeft');
  const without = await picture(), shown = await set(true);
  assert.ok(share(without, shown) > 0.002, `${share(without, shown)} of the view is what no camera saw`);
  const [download] = await Promise.all(
    [other.page.waitForEvent('download'), other.page.evaluate(() => document.getElementById('mesh-file').click())]);
  const glb = readFileSync(await download.path()), begin = 20 + glb.readUInt32LE(12);
  const { accessors, bufferViews, meshes } = JSON.parse(glb.subarray(20, begin).toString());
  const { TEXCOORD_0, _PROVENANCE } = meshes[0].primitives[0].attributes;
  const { bufferView, byteOffset, count, extras } = accessors[_PROVENANCE];
  assert.equal(bufferView, accessors[TEXCOORD_0].bufferView); // the second coordinate's last byte
  const counts = [0, 0, 0, 0];
  for (let i = 0; i < count; ++i) ++counts[glb[begin + 8 + bufferViews[bufferView].byteOffset + byteOffset + 8 * i]];
  assert.deepEqual(counts, ['both', 'left', 'right', 'nobody'].map((name) => extras[name] ?? 0));
  assert.deepEqual(other.complaints, []);
  rmSync(whole);
});

await check('without WebGL there is the picture of the relief, and the reason', async () => {
  const other = await open(browser, file, {}, () => { HTMLCanvasElement.prototype.getContext = () => null; });
  assert.equal(await other.page.evaluate(() => document.body.dataset.state), 'failed');
  assert.deepEqual(other.complaints, []);
  assert.match(await other.page.textContent('#problem'), /no WebGL/);
  assert.ok(await other.page.evaluate(() => document.getElementById('poster').naturalWidth) > 100);
});

await check('a gallery leads to the page, and is sorted', async () => {
  copyFileSync(file, join(folder, 'z.html'));
  execFileSync(program, ['gallery', folder], { stdio: 'pipe' });
  const other = await open(browser, join(folder, 'index.html'));
  const names = () => other.page.locator('tbody a').allTextContents();
  assert.deepEqual(await names(), [kName, 'z']);
  for (let i = 0; i < 2; ++i) await other.page.click('thead button');
  assert.deepEqual(await names(), ['z', kName]);
  assert.equal(await other.page.locator('tbody img').evaluateAll((all) => all.filter((each) => each.naturalWidth > 100).length), 2);
  await other.page.click(`tbody a >> nth=1`);
  await other.page.waitForFunction(() => document.body.dataset.state === 'ready');
  assert.equal(await other.page.title(), kName);
  assert.deepEqual(other.complaints, []);
});

await browser.close();
console.log(`${failures} failed`);
process.exit(failures ? 1 : 0);
