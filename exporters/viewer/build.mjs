// build.mjs MODULES FOLDER: page.html and gallery.html, each one file without its content, which the program fills in. Their
// policies let run nothing but the one script and the one style sheet in them, which they name by their hashes.
import { createHash } from 'node:crypto';
import { readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const [modules, folder] = process.argv.slice(2);
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

// page/NAME.html with its script and style sheet in it, and the policy that lets nothing else run.
function write(name, entry, notices) {
  const script = notices + bundle(entry, { format: 'esm' }).replaceAll('</script', '<\\/script');
  const style = bundle(`${name}.css`, {});
  const policy = `default-src 'none'; script-src ${hash(script)}; style-src ${hash(style)}; img-src data: blob:; ` +
    "base-uri 'none'; form-action 'none'";
  let text = readFileSync(join(page, `${name}.html`), 'utf8');
  for (const [mark, value] of Object.entries({ policy, style, script })) text = text.replace(`@${mark}@`, () => value);
  writeFileSync(join(folder, `${name}.html`), text);
}

write('page', 'main.js', licence('three', 'LICENSE') + licence('meshoptimizer', 'LICENSE.md'));
write('gallery', 'gallery.js', '');
