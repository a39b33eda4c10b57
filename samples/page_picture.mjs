// page_picture.mjs MODULES PAGE OUT.jpg [KEY...]: a page (.html) in Chromium, after the keys were pressed on its relief, as the
// picture in the main README. MODULES: build/npm, which tests/npm-install.sh makes.
import { writeFileSync } from 'node:fs';
import { launch, open, settle } from '../tests/exporters/viewer/browser.mjs';

const [modules, file, out, ...keys] = process.argv.slice(2);
const browser = await launch(modules);
const { page } = await open(browser, file, { viewport: { width: 1200, height: 720 } });
await page.focus('#view');
for (const key of keys) await page.keyboard.press(key);
await page.evaluate(() => { document.getElementById('view').style.outline = 'none'; });
await settle(page);
writeFileSync(out, await page.screenshot({ type: 'jpeg', quality: 78 }));
await browser.close();
