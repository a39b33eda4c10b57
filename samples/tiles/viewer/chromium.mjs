// Headless Chromium for fly.mjs and picture.mjs, and how they know that a view is complete.
import { existsSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const kChromium = '/usr/bin/chromium';

// Ends the process with 77 where Chromium or one of the packages is not there. modules: a folder node_modules.
export async function launch_chromium(modules, packages) {
    for (const needed of [kChromium, ...['playwright-core', ...packages].map((name) => join(modules, name))]) {
        if (existsSync(needed)) continue;
        console.log(`SKIPPED: ${needed} is not there`);
        process.exit(77);
    }
    return createRequire(join(modules, 'x.js'))('playwright-core').chromium.launch({
        executablePath: kChromium,
        args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
    });
}

// In the page: draws until nothing that the view needs is on its way, and once more.
export async function draw_all() {
    const { draw, tiles } = window.viewer;
    for (let calm = 0, tries = 0; calm < 5 && tries < 400; ++tries) {
        await new Promise((done) => setTimeout(done, 20));
        draw();
        const { downloading, parsing, queued = 0 } = tiles.stats;
        calm = downloading + parsing + queued === 0 ? calm + 1 : 0;
    }
    draw();
}
