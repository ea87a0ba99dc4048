// web/dist is what web/ui builds to, byte for byte.
//   node dist.mjs WORK
// Exit code 1: it is not (./run web); 77: the page's packages are not installed.
import { spawnSync } from 'node:child_process';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

const web = fileURLToPath(new URL('../../../web/', import.meta.url));
const work = process.argv[2];
if (!existsSync(join(web, 'ui/node_modules/esbuild'))) {
  console.log('the packages of web/ui are not installed (./run web installs them)');
  process.exit(77);
}
const built = spawnSync(process.execPath, [join(web, 'ui/build.mjs'), work], { stdio: 'inherit' });
if (built.status !== 0) process.exit(1);
const names = readdirSync(join(web, 'dist')).sort();
let different = names.join() !== readdirSync(work).sort().join();
for (const name of names) {
  if (existsSync(join(work, name)) && readFileSync(join(work, name)).equals(readFileSync(join(web, 'dist', name)))) continue;
  console.log(`web/dist/${name} is not what web/ui builds: ./run web`);
  different = true;
}
process.exit(different ? 1 : 0);
