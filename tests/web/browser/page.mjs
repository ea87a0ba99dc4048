// The page in a real browser on a live demo. Screenshots go to the folder named last, for looking at.
//   node page.mjs CMMLIVE WORK [SCREENSHOTS]
// Exit code 1: something is not as it should be; 77: playwright-core (./run web installs it) or chromium is not installed.
import { spawn } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';

const [program, work, shots] = process.argv.slice(2);
const browserPath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
let chromium;
try {
  ({ chromium } = createRequire(new URL('../../../web/ui/', import.meta.url))('playwright-core'));
} catch {
  console.log('playwright-core is not installed');
  process.exit(77);
}
if (!browserPath) {
  console.log('chromium is not installed');
  process.exit(77);
}

const token = '0123456789abcdef-of-the-test';
const tokenFile = join(work, 'token');
writeFileSync(tokenFile, token, { mode: 0o600 });
let port = 0;
const running = [];

/** A demo with its page, up to its address. */
function demo(out, ...more) {
  const child = spawn(program, ['demo', '--out', join(work, out), '--serve', `127.0.0.1:${port}`, '--token-file', tokenFile, ...more]);
  running.push(child);
  let said = '';
  return new Promise((resolve, reject) => {
    child.stderr.on('data', (text) => {
      said += text;
      const found = /page: (http:\S+:(\d+)\/)#token=/.exec(said);
      if (found) {
        port = Number(found[2]);
        resolve(Object.assign(child, { url: found[1] }));
      }
    });
    child.on('exit', (code) => reject(new Error(`the demo ended with ${code}: ${said}`)));
  });
}
const ended = (child) => new Promise((resolve) => (child.exitCode !== null || child.signalCode !== null ? resolve() : child.on('exit', resolve)));

let failed = 0;
function check(name, good, detail = '') {
  console.log((good ? 'ok   ' : 'FAIL ') + name, good ? '' : detail);
  if (!good) ++failed;
}
async function until(page, name, predicate, argument, timeout = 30000) {
  const good = await page.waitForFunction(predicate, argument, { timeout, polling: 50 }).then(() => true, () => false);
  check(name, good);
}
async function picture(page, name) {
  if (!shots) return;
  mkdirSync(shots, { recursive: true });
  await page.screenshot({ path: join(shots, name + '.png'), fullPage: true });
}
/** How many pixels of a canvas differ from its most frequent colour: something is drawn. */
const drawn = (page, id) => page.evaluate((canvasId) => {
  const canvas = document.getElementById(canvasId);
  const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let i = 3; i < data.length; i += 4) if (data[i]) ++count;
  return count;
}, id);

const browser = await chromium.launch({
  executablePath: browserPath,
  args: ['--no-sandbox', '--disable-gpu', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
});
try {
  let job = await demo('run', '--speed', '2', '--stay');
  const context = await browser.newContext({ viewport: { width: 1440, height: 1000 }, locale: 'en-GB', colorScheme: 'light' });
  const page = await context.newPage();
  const complaints = [];
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('console', (message) => { if (/Content Security Policy/i.test(message.text())) complaints.push(message.text()); });
  await page.goto(`${job.url}#token=${token}`);
  check('the token leaves the address', !page.url().includes(token), page.url());
  await until(page, 'measuring is shown', () => document.body.dataset.motion === 'scanning');
  await until(page, 'link health', () => document.getElementById('link').innerText.includes('Link'));
  await until(page, 'points appear', () => Number(document.body.dataset.points) > 100);
  await until(page, 'whiskers of the live section', () => Number(document.getElementById('section').dataset.whiskers) > 50);
  check('something is drawn', (await drawn(page, 'section')) > 2000 && (await drawn(page, 'strip')) > 500);
  await picture(page, 'live');
  await until(page, 'sections in space', () => Number(document.getElementById('blade').dataset.sections) >= 2);
  check('the blade is drawn', (await drawn(page, 'blade')) > 2000);
  check('progress', (await page.locator('#progress').evaluate((element) => element.value)) > 0.1);

  // A point is left out and taken back, by keyboard.
  await page.keyboard.press('[');
  await page.locator('#section-choice').selectOption('0');
  await until(page, 'a section with its characteristics', () => document.querySelectorAll('#table-body .badge').length >= 8);
  check('decision and limit stand in view', await page.evaluate(() => {
    const box = document.querySelector('.table .scroll');
    return box.scrollWidth <= box.clientWidth;
  }));
  check('decisions have words', /accepted|rejected|undecided/.test(await page.locator('#table-body').innerText()));
  await page.locator('#section').focus();
  await page.keyboard.press('n');
  await page.locator('#point').waitFor();
  await page.keyboard.press('r');
  await until(page, 'a point is left out', () => document.getElementById('point').innerText.includes('by operator'));
  await until(page, 'and listed', () => document.getElementById('rejected').innerText.includes('by operator'));
  await picture(page, 'left-out');
  await page.keyboard.press('u');
  await until(page, 'and taken back', () => !document.getElementById('rejected').innerText.includes('by operator'));
  await page.keyboard.press('Escape');

  await page.locator('#language').click();
  await until(page, 'Chinese', () => document.documentElement.lang === 'zh-CN' && document.body.innerText.includes('特征值'));
  await picture(page, 'chinese');
  await page.locator('#language').click();
  await page.locator('#theme').click();
  const ground = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  check('dark', ground.match(/\d+/g).every((channel) => Number(channel) < 80), ground);
  await picture(page, 'dark');
  await page.locator('#theme').click();

  await page.setViewportSize({ width: 390, height: 844 });
  check('no sideways scrolling on a phone', await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
  await picture(page, 'phone');
  await page.setViewportSize({ width: 1440, height: 1000 });
  const other = await (await browser.newContext({ locale: 'zh-CN', colorScheme: 'dark' })).newPage();
  await other.goto(job.url);
  await until(other, 'the browser chooses the language', () => document.documentElement.lang === 'zh-CN');
  await other.context().close();

  await until(page, 'the end and its verdict', () => document.body.dataset.motion === 'ended' && !!document.querySelector('#state .badge'), null, 60000);
  await until(page, 'the stop button is gone', () => document.getElementById('stop').hidden);
  await until(page, 'and the list of runs has it', () => !!document.querySelector('#runs-body .badge:not(.open_run)'));
  await page.locator('#follow').click();
  await page.keyboard.press('0');
  await picture(page, 'ended');

  // The server is killed, and another begins at the same place with a new run.
  job.kill('SIGKILL');
  await ended(job);
  await until(page, 'the page says that nobody answers', () => document.body.dataset.connected === 'false' && !document.getElementById('notice').hidden);
  await picture(page, 'waiting');
  job = await demo('run', '--speed', '0.25');
  await until(page, 'it goes on with the new run', () => document.body.dataset.connected === 'true' && document.body.dataset.motion === 'scanning' && Number(document.body.dataset.points) > 20);
  check('the first section is measured again', Number(await page.locator('#blade').getAttribute('data-sections')) < 8);

  // Without the token nothing stops.
  const stranger = await (await browser.newContext()).newPage();
  await stranger.goto(job.url);
  await stranger.locator('#stop').click();
  await stranger.locator('#token-dialog[open]').waitFor();
  await stranger.locator('#token').fill('not-the-token-at-all');
  await stranger.locator('#token-use').click();
  await stranger.locator('#token-dialog[open]').waitFor();
  await picture(stranger, 'token');
  check('a wrong token does not stop it', job.exitCode === null);
  await stranger.context().close();

  await page.locator('#stop').click();
  await ended(job);
  check('the stop button stops', job.exitCode === 4, String(job.exitCode));
  await until(page, 'and the page says so', () => ['stopped', 'fault'].includes(document.body.dataset.motion) || document.body.dataset.connected === 'false');
  check('no complaint of the browser', complaints.length === 0, complaints.join('\n'));
  check('the run file is there', readFileSync(join(work, 'run', 'run.cmmrun')).length > 4096);
} finally {
  await browser.close();
  for (const child of running) if (child.exitCode === null && child.signalCode === null) child.kill('SIGKILL');
}
console.log(failed ? `${failed} failed` : 'all as it should be');
process.exit(failed ? 1 : 0);
