// Chromium without a screen, the pages in it, and pictures of them.
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';

const kArguments = ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

export function launch(modules) {
  const { chromium } = createRequire(join(resolve(modules), 'x.js'))('playwright-core');
  return chromium.launch({ executablePath: '/usr/bin/chromium', args: kArguments });
}

// A page, once it shows its relief or says why not. `complaints` grows by what it logs and asks for. It does not sway,
// unless options say so.
export async function open(browser, file, options = {}, script = undefined) {
  const context = await browser.newContext({ acceptDownloads: true, reducedMotion: 'reduce', ...options });
  const page = await context.newPage();
  page.setDefaultTimeout(10000);
  const complaints = [];
  page.on('console', (message) => complaints.push(`console: ${message.text()}`));
  page.on('pageerror', (error) => complaints.push(`error: ${error.message}`));
  const url = `file://${encodeURI(resolve(file)).replaceAll('#', '%23').replaceAll('?', '%3F')}`;
  page.on('request', (request) => {
    const local = ['data:', 'blob:'].some((kind) => request.url().startsWith(kind));
    if (!local && !request.isNavigationRequest()) complaints.push(`request: ${request.url()}`);
  });
  if (script) await page.addInitScript(script);
  await page.goto(url);
  await page.waitForFunction(() => document.readyState === 'complete' && document.body.dataset.state !== 'loading');
  return { page, complaints };
}

// PNG bytes to {width, height, data: RGBA}, decoded by the browser.
export async function pixels(page, png) {
  const picture = await page.evaluate(async (text) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes]), { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
    const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
    const context = canvas.getContext('2d');
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    let letters = '';
    for (let i = 0; i < data.length; i += 8192) letters += String.fromCharCode(...data.subarray(i, i + 8192));
    return { width: bitmap.width, height: bitmap.height, text: btoa(letters) };
  }, png.toString('base64'));
  return { width: picture.width, height: picture.height, data: Buffer.from(picture.text, 'base64') };
}

// Waits until what was asked for is drawn.
export async function settle(page) {
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

export async function shot(page) {
  await settle(page);
  return pixels(page, await page.screenshot());
}

// Per pixel, the largest difference of a channel.
export function differences(a, b) {
  const out = new Uint8Array(a.width * a.height);
  for (let i = 0; i < out.length; ++i)
    for (let c = 0; c < 3; ++c) out[i] = Math.max(out[i], Math.abs(a.data[4 * i + c] - b.data[4 * i + c]));
  return out;
}
