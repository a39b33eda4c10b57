// ready.mjs MODULES PAGE: how long a page takes until its relief can be turned, in ms; the median of five times after a first
// one, which starts the browser's drawing as well. Measured, not tested.
import { launch, open } from './browser.mjs';

const [modules, file] = process.argv.slice(2);
const browser = await launch(modules);
const runs = [];
for (let i = 0; i < 6; ++i) {
  const { page } = await open(browser, file, { viewport: { width: 1100, height: 700 } });
  runs.push(await page.evaluate(() => performance.getEntriesByType('mark').map(({ name, startTime }) => [name, startTime])));
  await page.context().close();
}
await browser.close();
const median = (values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)];
runs[0].forEach(([name, first], step) => {
  console.log(`${name.padEnd(9)} ${Math.round(median(runs.slice(1).map((run) => run[step][1])))} (first ${Math.round(first)})`);
});
