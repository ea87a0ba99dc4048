// web/ui's script -> web/dist/app.js (or into the folder named on the command line): one file, nothing from outside.
import { build } from 'esbuild';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const dist = process.argv[2] ?? join(here, '..', 'dist');
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
