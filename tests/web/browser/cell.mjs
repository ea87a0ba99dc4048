// The page of a cell in a real browser: it goes from one part to the next while a PLC (tests/peers/cell_plc.py) has two measured.
//   node cell.mjs CMMLIVE WORK, from the project's root
// Exit code 1: something is not as it should be; 77: playwright-core, chromium or python3-pymodbus is not installed.
import { spawn, spawnSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const [program, work] = process.argv.slice(2);
const browserPath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
let chromium;
try {
  ({ chromium } = createRequire(new URL('../../../web/ui/', import.meta.url))('playwright-core'));
} catch { /* told below */ }
if (!chromium || !browserPath || spawnSync('/usr/bin/python3', ['-c', 'import pymodbus']).status !== 0) {
  console.log('playwright-core, chromium or pymodbus is not installed');
  process.exit(77);
}

rmSync(work, { recursive: true, force: true });
mkdirSync(join(work, 'parts'), { recursive: true });
copyFileSync('config/parts/demo.toml', join(work, 'parts', '1.toml'));
const running = [];
/** A program, up to what it says first. */
function start(pattern, command, ...args) {
  const child = spawn(command, args);
  running.push(child);
  let said = '';
  return new Promise((resolve, reject) => {
    const hear = (text) => {
      said += text;
      const found = pattern.exec(said);
      if (found) resolve(Object.assign(child, { found: found[1] }));
    };
    child.stdout.on('data', hear);
    child.stderr.on('data', hear);
    child.on('exit', (code) => reject(new Error(`${command} ended with ${code}: ${said}`)));
  });
}

let failed = 0;
function check(name, good) {
  console.log((good ? 'ok   ' : 'FAIL ') + name);
  if (!good) ++failed;
}
const browser = await chromium.launch({ executablePath: browserPath, args: ['--no-sandbox', '--disable-gpu', '--no-first-run', '--disable-background-networking'] });
try {
  const machine = await start(/(modbus\+tcp:\S+)/, program, 'sim', '--part', 'config/parts/demo.toml', '--listen', 'modbus+tcp://127.0.0.1:0', '--speed', '5');
  const cell = await start(/page":"(http:[^"]+)"/, program, 'cell', '--machine', machine.found, '--parts', join(work, 'parts'), '--runs', join(work, 'runs'),
    '--plc', 'modbus+tcp://127.0.0.1:0', '--serve', '127.0.0.1:0', '--json');
  const plcPort = await fetch(cell.found.replace(/\/#.*/, '/api/cell')).then((answer) => answer.json()).then((state) => state.plc.port);
  const page = await browser.newPage();
  const complaints = [];
  page.on('pageerror', (error) => complaints.push(error.message));
  await page.goto(cell.found);
  const until = async (name, predicate, argument) =>
    check(name, await page.waitForFunction(predicate, argument, { timeout: 60000, polling: 50 }).then(() => true, () => false));
  const plc = spawn('/usr/bin/python3', ['tests/peers/cell_plc.py', String(plcPort), '2'], { stdio: 'inherit' });
  running.push(plc);
  const ended = new Promise((resolve) => plc.on('exit', resolve));
  for (const run of ['000001-PY-0000', '000002-PY-0001']) {
    await until(`run ${run} is shown without being asked for`, (id) => document.body.dataset.run === id, run);
    await until('and live', () => document.body.dataset.motion === 'scanning' && Number(document.body.dataset.points) > 50);
  }
  check('the PLC had its parts', (await ended) === 0);
  await until('the end', () => document.body.dataset.motion === 'ended');
  await until('both are listed', () => document.body.innerText.includes('PY-0000') && document.body.innerText.includes('PY-0001'));
  check('no complaint of the browser', complaints.length === 0);
} finally {
  await browser.close();
  for (const child of running) if (child.exitCode === null && child.signalCode === null) child.kill('SIGKILL');
}
console.log(failed ? `${failed} failed` : 'all as it should be');
process.exit(failed ? 1 : 0);
