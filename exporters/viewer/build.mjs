// build.mjs MODULES OUT: the page as one file without a scene in it, for html_exporter.cpp to fill in. Its policy lets
// run nothing but the one script and the one style sheet in it, which it names by their hashes.
import { createHash } from 'node:crypto';
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const [modules, out] = process.argv.slice(2);
const esbuild = createRequire(join(resolve(modules), 'x.js'))('esbuild');
const page = join(dirname(fileURLToPath(import.meta.url)), 'page');

// What is packed in asks for its licence to go with it.
const licence = (name, file) => `/*! ${name}: ${readFileSync(join(modules, name, file), 'utf8').trim()} */\n`;

function bundle(entry, options) {
  const { outputFiles } = esbuild.buildSync({
    entryPoints: [join(page, entry)], bundle: true, minify: true, write: false, target: 'es2022', legalComments: 'none',
    nodePaths: [resolve(modules)], ...options,
  });
  return outputFiles[0].text;
}

const hash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;

const script = licence('three', 'LICENSE') + licence('meshoptimizer', 'LICENSE.md') +
  bundle('main.js', { format: 'esm' }).replaceAll('</script', '<\\/script');
const style = bundle('page.css', {});
const policy = `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; img-src data: blob:; ` +
  "base-uri 'none'; form-action 'none'";
let text = readFileSync(join(page, 'page.html'), 'utf8');
for (const [mark, value] of Object.entries({ policy, style, script })) text = text.replace(`@${mark}@`, () => value);
writeFileSync(out, text);
console.log(`${out}: ${text.length} bytes`);
