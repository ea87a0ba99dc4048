// web/ui -> web/dist (or the folder named on the command line): one script, one style, one page, nothing from outside.
import { build } from 'esbuild';
import { copyFileSync, mkdirSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const dist = process.argv[2] ?? join(here, '..', 'dist');
mkdirSync(dist, { recursive: true });
await build({
  entryPoints: [join(here, 'main.ts')],
  absWorkingDir: here,
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2022',
  charset: 'utf8',
  legalComments: 'none',
  outfile: join(dist, 'app.js'),
});
for (const file of ['index.html', 'style.css', 'icon.svg']) copyFileSync(join(here, file), join(dist, file));
