// The page: what is on the screen, and what a person does there.
import type { Decision, LivePoint, RunSummary, Section, Status } from './documents';
import { BladeView } from './blade_view';
import { length } from './canvas';
import { badge, cells, limits, make, shown, withSmall, withUncertainty } from './elements';
import { Run } from './run';
import { SectionView, type Spot } from './section_view';
import { Refused, get, post, takeToken, useToken } from './server';
import { drawStrip } from './strip_view';
import { drawTrend } from './trend_view';
import { type Word, language, named, say, switchLanguage } from './words';

const byId = <T extends HTMLElement = HTMLElement>(id: string) => document.getElementById(id) as T;

let status: Status | null = null;
let run: Run | null = null;
let runs: RunSummary[] = [];
let chosenSection: number | null = null; // nothing: the one under the probe
let selected: Spot | null = null;
let trendOf = 'profile_suction';
let stopping = false;
let problem = '';

const section = new SectionView(byId<HTMLCanvasElement>('section'));
const blade = new BladeView(byId<HTMLCanvasElement>('blade'));

const halfLimit = () => (run?.plan?.profile_mm ?? 0.1) / 2;
function shownSection(): number {
  if (chosenSection !== null) return chosenSection;
  if (run && run.current >= 0) return run.current;
  return run?.final.size ? Math.max(...run.final.keys()) : 0;
}
const finalShown = (): Section | undefined => run?.final.get(shownSection());
const liveShown = (): LivePoint[] => run?.live.get(shownSection()) ?? [];

function drawHeader() {
  byId('part').textContent = run?.plan?.part ?? '';
  byId('serial').textContent = [run?.plan?.serial, run?.plan?.machine].filter(Boolean).join(' · ');
  const state = byId('state');
  state.replaceChildren();
  if (!run) {
    state.append(make('span', say('idle')));
  } else {
    const motion: Word = run.motion;
    const marks: Record<string, string> = { scanning: '▶', held: '❚❚', fault: '✕', ended: '■', stopped: '■', beginning: '…', open_run: '…' };
    const chip = make('span', '', 'motion ' + motion);
    const mark = make('span', marks[motion] ?? '', 'mark');
    mark.setAttribute('aria-hidden', 'true');
    chip.append(mark, say(motion));
    state.append(chip);
    const verdict = run.result?.result.verdict;
    if (verdict && (run.motion === 'ended' || run.motion === 'stopped' || run.motion === 'fault')) state.append(badge(verdict));
  }
  byId<HTMLProgressElement>('progress').value = run?.share() ?? 0;
  const left = run?.remaining() ?? null;
  byId('remaining').textContent = left === null ? `${Math.round(100 * (run?.share() ?? 0))} %`
    : `${Math.round(100 * (run?.share() ?? 0))} % · ` + say('remaining', { t: left < 90 ? `${Math.ceil(left)} s` : `${Math.ceil(left / 60)} min` });
  const link = status?.job?.link, box = byId('link');
  box.replaceChildren();
  if (link) {
    const bad = link.errors > 0;
    const text = make('span', `${bad ? '!' : '✓'} ${say('link')}: ${bad ? say('link_bad', { n: link.errors }) : say('link_good')}`, bad ? 'doubtful' : '');
    text.title = `${link.exchanges} · ${link.mean_round_trip_ms.toFixed(2)} / ${link.max_round_trip_ms.toFixed(1)} ms · ${link.retries} · ${link.reconnects}${link.note ? ' · ' + link.note : ''}`;
    box.append(text, make('small', `${link.mean_round_trip_ms.toFixed(2)} ms`));
  }
  const stop = byId<HTMLButtonElement>('stop');
  const running = !!(run?.isLive && status?.job?.running && status.job.may_stop);
  stop.hidden = !running;
  stop.textContent = say(stopping ? 'stopping' : 'stop');
  stop.disabled = stopping;
  const notice = byId('notice');
  let text = problem;
  if (run && !run.connected) text = say('waiting');
  else if (!text && run?.message && (run.motion === 'held' || run.motion === 'fault')) text = run.message;
  notice.textContent = text;
  notice.hidden = !text;
}

function drawSection() {
  const at = shownSection(), plan = run?.plan?.sections.find((one) => one.index === at), final = finalShown(), live = liveShown();
  section.show({ plan, live, final, halfLimit: halfLimit(), ball: run?.plan?.ball_radius_mm ?? 1, selected: selected?.seq ?? null });
  drawStrip(byId<HTMLCanvasElement>('strip'), run?.plan ?? null, final, live, run?.expected.get(at) ?? 0);
  const count = final ? final.points.length : live.length, expected = run?.expected.get(at);
  const bits = [final ? '' : count ? say('provisional') : say('planned'), `${count}${!final && expected ? ' / ' + expected : ''} ${say('points')}`];
  if (run?.plan?.has_nominal) bits.push(say('magnified', { n: section.magnification }));
  else if (run?.plan) bits.push(say('no_nominal'));
  if (final?.why) bits.push(final.why);
  byId('section-caption').textContent = bits.filter(Boolean).join(' · ');
  const title = byId('section-title');
  title.replaceChildren(plan ? say('section_of', { i: at, z: plan.z_mm.toFixed(1) }) : say('section'));
  if (final) title.append(' ', badge(final.decision));
  else if (run?.doomed.has(at)) title.append(' ', badge('reject'));
  const whiskers = [...live, ...(final?.contour ?? [])].length;
  byId('section').setAttribute('aria-label', `${title.textContent}: ${byId('section-caption').textContent}`);
  byId('section').dataset.whiskers = String(whiskers);
  byId('strip').setAttribute('aria-label', say('strip'));
  byId('follow').setAttribute('aria-pressed', String(chosenSection === null));
  const choice = byId<HTMLSelectElement>('section-choice'), all = run?.plan?.sections ?? [];
  if (choice.options.length !== all.length || choice.dataset.language !== language()) {
    choice.replaceChildren(...all.map((one) => new Option(say('section_of', { i: one.index, z: one.z_mm.toFixed(1) }), String(one.index))));
    choice.dataset.language = language();
  }
  choice.value = String(at);
}

function drawBlade() {
  if (!run?.plan) return;
  blade.show(run.plan.sections, run.final, halfLimit());
  byId('scale-low').textContent = '−' + length(halfLimit());
  byId('scale-high').textContent = '+' + length(halfLimit());
  byId('blade').setAttribute('aria-label', `${say('blade')}: ${run.final.size} / ${run.plan.sections.length} ${say('sections')}`);
  byId('blade').dataset.sections = String(run.final.size);
}

function drawTable() {
  const head = make('tr');
  const titles: [Word, Word?][] = [['characteristic'], ['decision'], ['value', 'u95'], ['limit', 'nominal']];
  for (const [word, below] of titles) head.append(withSmall('th', say(word), below ? say(below) : ''));
  byId('table-head').replaceChildren(head);
  const final = finalShown();
  byId('table-title').textContent = final ? `${say('characteristics')} · ${say('section')} ${final.index}` : say('characteristics');
  const ofPart = (run?.result?.result.characteristics ?? []).filter((c) => c.section === null || c.section === shownSection());
  const rows = [...ofPart.map((c) => [c, c.section === null] as const), ...(final?.characteristics ?? []).map((c) => [c, false] as const)];
  byId('table-body').replaceChildren(...rows.map(([c, whole]) => {
    const row = make('tr'), name = make('span', named(c.name) + (whole ? ` (${say('whole_part')})` : ''));
    name.title = [c.method, c.note].filter(Boolean).join('\n');
    cells(row, [name, badge(c.decision), withUncertainty(c), withSmall('span', limits(c), shown(c, c.nominal, 4))], [2, 3]);
    return row;
  }));
  if (!rows.length) {
    const row = make('tr'), cell = make('td', say('planned'), 'soft');
    cell.colSpan = titles.length;
    row.append(cell);
    byId('table-body').replaceChildren(row);
  }
}

function drawRejected() {
  const points = (finalShown()?.points ?? []).filter((point) => point[3] !== 'none');
  byId('rejected-title').textContent = `${say('rejected')} (${points.filter((point) => point[3] !== 'kept').length})`;
  const list = byId('rejected');
  list.replaceChildren(...points.slice(0, 200).map(([seq, x, y, reason, residual]) => {
    const item = make('li'), show = make('button', `${seq}`, 'plain');
    show.type = 'button';
    show.onclick = () => { choose({ seq, x, y, reason, residual }); section.lookAt([x, y], 4); };
    item.append(show, make('span', `${named(reason)} · ${residual >= 0 ? '+' : ''}${length(residual)}`));
    item.append(decisionButton(seq, reason));
    return item;
  }));
  if (!points.length) list.replaceChildren(make('li', say('none'), 'soft'));
}

/** What can be decided about a point as it is. */
function decisionButton(seq: number, reason: string): HTMLButtonElement {
  const word: 'undo' | 'reject' | 'restore' = reason === 'by_operator' || reason === 'kept' ? 'undo' : reason === 'none' ? 'reject' : 'restore';
  const button = make('button', say(word));
  button.type = 'button';
  button.dataset.decide = word;
  button.dataset.seq = String(seq);
  button.onclick = () => void decide(word, seq);
  return button;
}

function drawPoint() {
  const box = byId('point');
  box.hidden = !selected;
  if (!selected) return;
  const now = section.spots().find((spot) => spot.seq === selected?.seq) ?? selected;
  const close = make('button', '✕', 'plain');
  close.type = 'button';
  close.setAttribute('aria-label', say('close'));
  close.onclick = () => choose(null);
  const parts: (string | HTMLElement)[] = [make('strong', say('point_of', { n: now.seq })),
    make('span', `x ${now.x.toFixed(4)} · y ${now.y.toFixed(4)} mm`), make('span', now.reason === 'none' ? say('used') : named(now.reason))];
  if (now.residual !== null) parts.push(make('span', say('residual', { r: now.residual.toFixed(4) })));
  if (finalShown()) parts.push(decisionButton(now.seq, now.reason));
  box.replaceChildren(...parts, close);
}

function drawRuns() {
  const head = make('tr');
  for (const word of ['run', 'started', 'part', 'serial', 'verdict'] as Word[]) head.append(make('th', say(word)));
  byId('runs-head').replaceChildren(head);
  const ordered = [...runs].sort((a, b) => (b.started_utc ?? '').localeCompare(a.started_utc ?? ''));
  byId('runs-body').replaceChildren(...ordered.map((one) => {
    const row = make('tr', '', one.id === run?.id ? 'current' : ''), show = make('a', one.id);
    show.href = '#run=' + encodeURIComponent(one.id);
    if (one.id === run?.id) show.setAttribute('aria-current', 'true');
    cells(row, [show, (one.started_utc ?? '').replace('T', ' ').replace('Z', ''), one.part ?? '', one.serial ?? '',
      one.problem ? make('span', one.problem, 'soft') : badge(one.verdict ? (one.complete === false && one.verdict !== 'reject' ? 'undecided' : one.verdict) : 'open_run')]);
    return row;
  }));
  const same = runs.filter((one) => !run?.plan || one.part === run.plan.part);
  const names = [...new Set(same.flatMap((one) => Object.keys(one.worst ?? {})))];
  const choice = byId<HTMLSelectElement>('trend-choice');
  if (!names.includes(trendOf)) trendOf = names[0] ?? trendOf;
  choice.replaceChildren(...names.map((name) => new Option(named(name), name, false, name === trendOf)));
  (choice.parentElement as HTMLElement).hidden = !names.length;
  byId('trend').hidden = !names.length;
  byId('trend').setAttribute('aria-label', `${say('trend')} ${named(trendOf)}`);
  drawTrend(byId<HTMLCanvasElement>('trend'), same, trendOf);
}

function drawWords() {
  document.documentElement.lang = language();
  document.querySelectorAll<HTMLElement>('[data-text]').forEach((element) => { element.textContent = say(element.dataset.text as Word); });
  const texts: [string, Word][] = [['blade-title', 'blade'], ['runs-title', 'runs'], ['trend-label', 'trend'], ['follow', 'follow'], ['whole', 'whole'],
    ['language', 'other'], ['help', 'help'], ['help-title', 'help'], ['help-close', 'close'], ['token-title', 'token'], ['token-text', 'token_text'],
    ['token-label', 'token'], ['token-use', 'use'], ['token-cancel', 'cancel']];
  for (const [id, word] of texts) byId(id).textContent = say(word);
  byId('theme').textContent = say(isDark() ? 'light' : 'dark');
  byId('previous').setAttribute('aria-label', say('previous'));
  byId('next').setAttribute('aria-label', say('next'));
  byId('section-choice').setAttribute('aria-label', say('section'));
  byId('progress').setAttribute('aria-label', say('scanning'));
  const keys: [string, Word][] = [['[  ]', 'key_section'], ['F', 'key_follow'], ['+  −  0', 'key_zoom'], ['L  T', 'key_edges'], ['N  P', 'key_point'],
    ['R', 'key_reject'], ['U', 'key_undo'], ['← → ↑ ↓', 'key_blade'], ['Shift+S', 'key_stop']];
  byId('help-list').replaceChildren(...keys.flatMap(([key, word]) => {
    const term = make('dt');
    term.append(make('kbd', key));
    return [term, make('dd', say(word))];
  }));
  byId('footer').textContent = status?.version ?? '';
}

let wanted = false, everything = false;
/** At most once a frame; points alone change less. */
function draw(what: 'all' | 'points' = 'all') {
  everything ||= what === 'all';
  if (wanted) return;
  wanted = true;
  requestAnimationFrame(() => {
    wanted = false;
    drawHeader();
    drawSection();
    if (everything) { drawBlade(); drawTable(); drawRejected(); drawPoint(); drawRuns(); drawWords(); }
    everything = false;
    document.body.dataset.motion = run?.motion ?? 'idle';
    document.body.dataset.run = run?.id ?? '';
    document.body.dataset.connected = String(run?.connected ?? true);
    document.body.dataset.points = String(run ? [...run.live.values()].reduce((sum, list) => sum + list.length, 0) : 0);
    document.body.dataset.gap = run?.gap ? run.gap.join('-') : '';
    if (run?.gap) byId('footer').textContent = `${status?.version ?? ''} · ${say('missing', { a: run.gap[0], b: run.gap[1] })}`;
  });
}

function choose(spot: Spot | null) { selected = spot; draw(); }
function chooseSection(index: number | null) {
  chosenSection = index;
  selected = null;
  draw();
}
function step(by: number) {
  const all = run?.plan?.sections.length ?? 0;
  if (all) chooseSection(Math.max(0, Math.min(all - 1, shownSection() + by)));
}
function stepPoint(by: number) {
  const spots = section.spots();
  if (!spots.length) return;
  const at = spots.findIndex((spot) => spot.seq === selected?.seq);
  choose(spots[at < 0 ? 0 : (at + by + spots.length) % spots.length]);
}

async function withToken<T>(act: () => Promise<T>): Promise<T | null> {
  try {
    problem = '';
    return await act();
  } catch (error) {
    if (error instanceof Refused && error.status === 401 && (await askToken())) return withToken(act);
    problem = say('failed', { why: error instanceof Error ? error.message : String(error) });
    draw();
    return null;
  }
}
function askToken(): Promise<boolean> {
  const dialog = byId<HTMLDialogElement>('token-dialog'), input = byId<HTMLInputElement>('token');
  input.value = '';
  dialog.returnValue = '';
  dialog.showModal();
  input.focus();
  return new Promise((resolve) => {
    dialog.onclose = () => {
      const given = dialog.returnValue === 'use' && input.value.trim() !== '';
      if (given) useToken(input.value.trim());
      resolve(given);
    };
  });
}
async function decide(word: 'reject' | 'restore' | 'undo', seq: number) {
  const at = run;
  if (!at) return;
  const done = await withToken(() => post(`/api/run/${encodeURIComponent(at.id)}/points`, { [word]: [seq] }));
  if (!done) return;
  await at.judgedAnew();
  const now = section.spots().find((spot) => spot.seq === seq);
  if (selected?.seq === seq && now) selected = now;
  draw();
}
function decideSelected(undo: boolean) {
  if (!selected || !finalShown()) return;
  const now = section.spots().find((spot) => spot.seq === selected?.seq);
  if (!now) return;
  const decided = now.reason === 'by_operator' || now.reason === 'kept';
  if (undo !== decided) return;
  void decide(undo ? 'undo' : now.reason === 'none' ? 'reject' : 'restore', now.seq);
}
async function stop() {
  if (byId<HTMLButtonElement>('stop').hidden || stopping) return;
  stopping = true;
  draw();
  const done = await withToken(() => post('/api/stop', {}));
  if (!done) stopping = false;
  draw();
}

const theme = 'cmmlive.theme';
const isDark = () => (document.documentElement.dataset.theme ?? (matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light')) === 'dark';
function switchTheme() {
  document.documentElement.dataset.theme = isDark() ? 'light' : 'dark';
  localStorage.setItem(theme, document.documentElement.dataset.theme);
  draw();
}

function openRun() {
  const named_ = /(?:^#|&)run=([^&]*)/.exec(location.hash);
  const newest = [...runs].sort((a, b) => (b.started_utc ?? '').localeCompare(a.started_utc ?? ''))[0];
  const id = named_ ? decodeURIComponent(named_[1]) : (status?.job?.id ?? newest?.id);
  if (!id || id === run?.id) return;
  run?.close();
  chosenSection = selected = null;
  stopping = false;
  problem = '';
  run = new Run(id, id === status?.job?.id && !!status?.job, draw);
  draw();
}

async function look() {
  try {
    const before = status?.job;
    status = await get<Status>('/api/status');
    if (!status.job?.running) stopping = false;
    if (before && (before.id !== status.job?.id || before.running !== status.job.running)) void lookAtRuns();
    if (!run || (run.isLive && status.job && status.job.id !== run.id)) openRun();
  } catch (error) {
    if (error instanceof Refused && error.status === 401 && (await askToken())) return look();
  }
  draw('points');
}
async function lookAtRuns() {
  try {
    runs = (await get<{ runs: RunSummary[] }>('/api/runs')).runs;
    if (!run) openRun();
    draw();
  } catch { /* the header says that the server is away */ }
}

function bind() {
  byId('stop').onclick = () => void stop();
  byId('language').onclick = () => { switchLanguage(); draw(); };
  byId('theme').onclick = switchTheme;
  byId('help').onclick = () => byId<HTMLDialogElement>('help-dialog').showModal();
  byId('previous').onclick = () => step(-1);
  byId('next').onclick = () => step(1);
  byId('follow').onclick = () => chooseSection(null);
  byId('whole').onclick = () => section.whole();
  byId('at-le').onclick = () => edge('le');
  byId('at-te').onclick = () => edge('te');
  byId<HTMLSelectElement>('section-choice').onchange = (e) => chooseSection(Number((e.target as HTMLSelectElement).value));
  byId<HTMLSelectElement>('trend-choice').onchange = (e) => { trendOf = (e.target as HTMLSelectElement).value; draw(); };
  section.pick = choose;
  document.addEventListener('keydown', (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test((e.target as HTMLElement).tagName) || document.querySelector('dialog[open]')) return;
    const act: Record<string, () => void> = {
      '[': () => step(-1), ']': () => step(1), f: () => chooseSection(null), '+': () => section.zoom(1.4), '=': () => section.zoom(1.4), '-': () => section.zoom(1 / 1.4),
      '0': () => section.whole(), l: () => edge('le'), t: () => edge('te'), n: () => stepPoint(1), p: () => stepPoint(-1), r: () => decideSelected(false),
      u: () => decideSelected(true), S: () => void stop(), '?': () => byId<HTMLDialogElement>('help-dialog').showModal(), Escape: () => choose(null),
    };
    const key = e.key.length === 1 && e.key !== 'S' ? e.key.toLowerCase() : e.key;
    if (!act[key]) return;
    e.preventDefault();
    act[key]();
  });
  addEventListener('hashchange', () => { useToken(takeToken()); openRun(); });
  new ResizeObserver(() => draw()).observe(document.body);
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => draw());
}
/** The edge of the finished section, or of the nominal: its ends along the chord. */
function edge(which: 'le' | 'te') {
  const final = finalShown();
  if (final?.[which]) return section.lookAt(final[which], 8);
}

const kept = localStorage.getItem(theme);
if (kept) document.documentElement.dataset.theme = kept;
useToken(takeToken());
bind();
draw();
void look().then(lookAtRuns);
setInterval(() => void look(), 1000);
setInterval(() => void lookAtRuns(), 5000);
export type { Decision };
