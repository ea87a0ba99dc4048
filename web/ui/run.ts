// One run as the page knows it, kept up to date by the server's events. Everything shown comes from here.
import type { Choice, LivePoint, Plan, Points, Result, RunEvent, Section, Status } from './documents';
import { EventStream, get } from './server';

export type Motion = 'beginning' | 'open_run' | 'scanning' | 'held' | 'fault' | 'ended' | 'stopped';

const wait = (ms: number) => new Promise((resolve) => setTimeout(resolve, ms));
const path = (id: string) => '/api/run/' + encodeURIComponent(id);

export class Run {
  plan: Plan | null = null;
  result: Result | null = null;
  choice: Choice = { rejected: [], restored: [] };
  live = new Map<number, LivePoint[]>();
  final = new Map<number, Section>();
  expected = new Map<number, number>(); // points of a section, where they are known
  current = -1;                         // section under the probe
  doomed = new Set<number>();           // sections that will be rejected whatever points come
  motion: Motion = 'beginning';
  message = '';
  gap: [number, number] | null = null;
  firstScan: number | null = null; // host time of the run, s
  private planned: { total: number; alignment: number } | null = null; // s, of a run that begins with datum points
  private began = 0;
  private heard = 0; // when the newest event came, ms of the page
  private aligned = false;
  lastTime = 0;
  connected = true;
  private next = 1;
  private lastPoint = 0;
  private stream: EventStream | null = null;
  private over = false;
  private fetching = false;
  private again = false;
  private restarts = 0;

  constructor(readonly id: string, readonly isLive: boolean, private changed: (what: 'all' | 'points') => void) {
    if (!isLive) this.motion = 'open_run';
    void this.begin();
  }
  close() {
    this.over = true;
    this.stream?.close();
  }

  /** Share of the whole run that is done: the alignment by datum points for its share of the time, then the sections. */
  share(): number {
    const measured = this.measured();
    if (!this.planned) return measured;
    const { total, alignment } = this.planned;
    const found = this.aligned || measured ? 1 : Math.min(1, (this.now() - this.began) / alignment);
    return measured + (found - measured) * (alignment / total);
  }
  /** Host time of the run; nothing is told while datum points are touched. */
  private now(): number {
    return this.isLive ? this.lastTime + (performance.now() - this.heard) / 1000 : this.lastTime;
  }
  /** Share of the sections that is measured, the points of the present one counted. */
  private measured(): number {
    const all = this.plan?.sections.length ?? 0;
    if (!all) return 0;
    if (this.final.size >= all) return 1;
    const expected = this.expected.get(this.current) ?? 0, seen = this.live.get(this.current)?.length ?? 0;
    const part = expected && !this.final.has(this.current) ? Math.min(1, seen / expected) : 0;
    return Math.min(1, (this.final.size + part) / all);
  }
  remaining(): number | null {
    const measured = this.measured();
    if (this.planned && !this.aligned && !measured && this.isLive) return this.planned.total * (1 - this.share());
    if (this.motion !== 'scanning' || this.firstScan === null || measured < 0.02) return null;
    return ((this.lastTime - this.firstScan) * (1 - measured)) / measured;
  }

  private async begin() {
    for (let pause = 400; !this.over; pause = Math.min(4000, pause * 1.5)) {
      try {
        const plan = await get<Plan>(path(this.id) + '/plan');
        if (this.over) return;
        if (this.plan && this.plan.run_id !== plan.run_id) this.forget();
        this.plan = plan;
        this.connected = true;
        break;
      } catch {
        // A job that begins has no run file yet; a server that was killed is back in a moment.
        const reached = await get<Status>('/api/status').then(() => true, () => false);
        this.connected = reached;
        this.changed('all');
        await wait(pause);
      }
    }
    if (this.over) return;
    this.changed('all');
    if (!this.isLive || this.restarts) await this.loadRecorded();
    this.listen();
  }
  private forget() {
    for (const map of [this.live, this.final, this.expected]) map.clear();
    this.current = -1;
    this.doomed.clear();
    this.next = 1;
    this.lastPoint = 0;
    this.firstScan = null;
    this.planned = null;
    this.aligned = false;
    this.gap = null;
    this.result = null;
    this.choice = { rejected: [], restored: [] };
    this.motion = this.isLive ? 'beginning' : 'open_run';
  }
  private async loadRecorded() {
    await this.readResult();
    const measured = this.result?.result.sections ?? [];
    await Promise.all(measured.map(({ index }) => this.loadSection(index)));
    await this.readPoints();
  }
  private async readResult() {
    try {
      this.result = await get<Result>(path(this.id));
      this.choice = this.result.choice;
    } catch { /* nothing measured yet */ }
  }

  private listen() {
    this.stream = new EventStream(this.id, this.next, (events) => this.take(events),
      () => { this.connected = true; this.changed('all'); },
      () => {
        if (this.over) return;
        this.connected = false;
        this.changed('all');
        ++this.restarts;
        void wait(Math.min(5000, 300 * this.restarts)).then(() => this.begin());
      });
  }
  private take(events: RunEvent[]) {
    this.restarts = 0;
    this.heard = performance.now();
    let points = false, all = false;
    for (const event of events) {
      if (event.seq !== undefined) this.next = event.seq + 1;
      if (event.t_host_s !== undefined) this.lastTime = event.t_host_s;
      const section = event.section as number | undefined;
      switch (event.event) {
        case 'RunStarted':
          this.began = event.t_host_s ?? 0;
          if (event.alignment_s) this.planned = { total: event.planned_s as number, alignment: event.alignment_s as number };
          all = true;
          break;
        case 'PartAligned':
          this.aligned = all = true;
          break;
        case 'SampleBatch':
          points = true;
          if (section !== undefined && this.current !== section) { this.current = section; all = true; }
          if (this.motion === 'beginning' || this.motion === 'held') { this.motion = 'scanning'; all = true; }
          break;
        case 'PathStarted':
          this.current = section ?? this.current;
          this.firstScan ??= event.t_host_s ?? null;
          if (event.points) this.expected.set(this.current, event.points as number);
          if (this.isLive) this.motion = 'scanning';
          points = all = true;
          break;
        case 'SectionFinal':
          if (section !== undefined && !this.final.has(section)) void this.loadSection(section);
          all = true;
          break;
        case 'SectionRevised':
          if (section !== undefined) void this.loadSection(section);
          all = true;
          break;
        case 'GateDecision':
          if (event.while_measuring && section !== undefined) { this.doomed.add(section); all = true; }
          break;
        case 'Hold': this.motion = 'held'; this.message = String(event.message ?? ''); all = true; break;
        case 'Resume': if (this.motion === 'held') this.motion = 'scanning'; this.message = ''; all = true; break;
        case 'MachineFault': this.motion = 'fault'; this.message = String(event.message ?? ''); all = true; break;
        case 'PointsChosen':
          this.choice = { rejected: event.rejected as number[], restored: event.restored as number[] };
          void this.judgedAnew();
          break;
        case 'RunStopped':
          if (this.motion !== 'fault') this.motion = event.complete ? 'ended' : 'stopped';
          points = all = true;
          void this.readResult().then(() => this.changed('all'));
          break;
        case 'Gap':
          this.next = Math.max(this.next, (event.last_seq as number) + 1);
          this.gap = [event.first_seq as number, event.last_seq as number];
          points = true;
          break;
        default: break;
      }
    }
    if (points) void this.readPoints();
    if (all) this.changed('all');
  }
  /** An operator has decided about points. */
  async judgedAnew() {
    await this.readResult();
    await Promise.all([...this.final.keys()].map((index) => this.loadSection(index)));
    this.changed('all');
  }

  private async loadSection(index: number) {
    for (let tries = 0; tries < 20 && !this.over; ++tries) {
      try {
        const section = await get<Section>(`${path(this.id)}/section?index=${index}`);
        if (section.finished || !this.isLive || tries === 19) {
          this.final.set(index, section);
          this.changed('all');
          return;
        }
      } catch { /* its points are on the way to the disk */ }
      await wait(100);
    }
  }
  /** One reading at a time; what was asked for meanwhile is read after it. */
  private async readPoints() {
    if (this.fetching) { this.again = true; return; }
    this.fetching = true;
    try {
      do {
        this.again = false;
        const news = await get<Points>(`${path(this.id)}/points?after=${this.lastPoint}`);
        this.lastPoint = Math.max(this.lastPoint, news.last);
        for (const point of news.points) {
          const section = point[1];
          if (!this.live.has(section)) this.live.set(section, []);
          this.live.get(section)!.push(point);
        }
        if (news.points.length) this.changed('points');
        this.again ||= news.more;
        if (this.again) await wait(60);
      } while (this.again && !this.over);
    } catch { /* the stream tells when the server is back */ }
    this.fetching = false;
    // Durable a moment after they were announced: what came last is read once more.
    const pause = this.motion === 'scanning' ? 250 : this.motion === 'open_run' ? 1500 : 0;
    if (pause) setTimeout(() => { if (!this.over && !this.fetching) void this.readPoints(); }, pause);
  }
}
