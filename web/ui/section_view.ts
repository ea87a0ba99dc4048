// The section under the probe, or one that is finished: nominal, contour, whiskers, points.
import type { LivePoint, PlanSection, Section } from './documents';
import { begin, deviationColour, palette, roundDown } from './canvas';

export interface SectionShown { plan?: PlanSection; live: LivePoint[]; final?: Section; halfLimit: number; ball: number; selected: number | null }
export interface Spot { seq: number; x: number; y: number; reason: string; residual: number | null }

const whiskerPixels = 60; // of the largest deviation

export class SectionView {
  private shown: SectionShown = { live: [], halfLimit: 0.05, ball: 1, selected: null };
  private centre: [number, number] = [0, 0];
  private scale = 0; // pixels a millimetre; 0: the whole section
  magnification = 1;
  pick: (spot: Spot | null) => void = () => undefined;

  constructor(readonly canvas: HTMLCanvasElement) {
    let from: [number, number] | null = null, moved = false;
    canvas.addEventListener('pointerdown', (e) => { from = [e.offsetX, e.offsetY]; moved = false; canvas.setPointerCapture(e.pointerId); });
    canvas.addEventListener('pointermove', (e) => {
      if (!from) return;
      const dx = e.offsetX - from[0], dy = e.offsetY - from[1];
      if (!moved && Math.hypot(dx, dy) < 4) return;
      moved = true;
      from = [e.offsetX, e.offsetY];
      this.freeze();
      this.centre = [this.centre[0] - dx / this.scale, this.centre[1] + dy / this.scale];
      this.draw();
    });
    canvas.addEventListener('pointerup', (e) => { if (!moved) this.pick(this.nearest(e.offsetX, e.offsetY)); from = null; });
    canvas.addEventListener('wheel', (e) => { e.preventDefault(); this.zoom(e.deltaY < 0 ? 1.25 : 0.8, e.offsetX, e.offsetY); }, { passive: false });
  }

  show(shown: SectionShown) { this.shown = shown; this.draw(); }

  whole() { this.scale = 0; this.draw(); }
  lookAt(place: [number, number] | undefined, span: number) {
    if (!place) return;
    this.centre = place;
    this.scale = Math.min(this.canvas.clientWidth, this.canvas.clientHeight) / span;
    this.draw();
  }
  zoom(factor: number, x = this.canvas.clientWidth / 2, y = this.canvas.clientHeight / 2) {
    this.freeze();
    const before = this.at(x, y);
    this.scale = Math.max(2, Math.min(20000, this.scale * factor));
    const after = this.at(x, y);
    this.centre = [this.centre[0] + before[0] - after[0], this.centre[1] + before[1] - after[1]];
    this.draw();
  }
  /** Points that a person can choose, in the order of measurement. */
  spots(): Spot[] {
    if (this.shown.final) return this.shown.final.points.map(([seq, x, y, reason, residual]) => ({ seq, x, y, reason, residual }));
    return this.shown.live.map(([seq, , x, y, touched]) => ({ seq, x, y, reason: touched ? 'none' : 'no_contact', residual: null }));
  }

  /** What is drawn as long as a whisker gets: what the section is out by, but not less than a sixth of the limit. */
  private largest(): number {
    const all = (this.shown.final?.contour.map((row) => row[5]) ?? this.shown.live.map((point) => point[5])).map((d) => Math.abs(d ?? 0)).sort((a, b) => a - b);
    return Math.max(this.shown.halfLimit / 6, all[Math.floor(all.length * 0.97)] ?? 0);
  }
  private fitted() {
    const xs: number[] = [], ys: number[] = [];
    const nominal = this.shown.plan?.nominal ?? [];
    for (let i = 0; i < nominal.length; i += 2) { xs.push(nominal[i]); ys.push(nominal[i + 1]); }
    if (!xs.length) for (const spot of this.spots()) { xs.push(spot.x); ys.push(spot.y); }
    if (!xs.length) return { centre: [0, 0] as [number, number], scale: 10 };
    const box = (v: number[]) => v.reduce(([a, b], c) => [Math.min(a, c), Math.max(b, c)], [Infinity, -Infinity]);
    const [x0, x1] = box(xs), [y0, y1] = box(ys), margin = 2 * this.shown.ball + 2;
    return {
      centre: [(x0 + x1) / 2, (y0 + y1) / 2] as [number, number],
      scale: Math.min(this.canvas.clientWidth / (x1 - x0 + margin + 4), this.canvas.clientHeight / (y1 - y0 + margin + 4)),
    };
  }
  private freeze() {
    if (this.scale) return;
    const f = this.fitted();
    this.centre = f.centre;
    this.scale = f.scale;
  }
  private view() { return this.scale ? { centre: this.centre, scale: this.scale } : this.fitted(); }
  private at(x: number, y: number): [number, number] {
    const v = this.view();
    return [v.centre[0] + (x - this.canvas.clientWidth / 2) / v.scale, v.centre[1] - (y - this.canvas.clientHeight / 2) / v.scale];
  }
  private nearest(x: number, y: number): Spot | null {
    const [px, py] = this.at(x, y), reach = 14 / this.view().scale;
    let best: Spot | null = null, distance = reach;
    for (const spot of this.spots()) {
      const d = Math.hypot(spot.x - px, spot.y - py);
      if (d < distance) { best = spot; distance = d; }
    }
    return best;
  }

  draw() {
    const frame = begin(this.canvas);
    if (!frame) return;
    const { g, width, height } = frame, p = palette(), v = this.view(), { plan, final, live, halfLimit } = this.shown;
    const X = (x: number) => width / 2 + (x - v.centre[0]) * v.scale, Y = (y: number) => height / 2 - (y - v.centre[1]) * v.scale;
    this.magnification = roundDown(Math.max(1, whiskerPixels / (this.largest() * v.scale)));
    const line = (points: [number, number][], closed: boolean) => {
      g.beginPath();
      points.forEach(([x, y], i) => (i ? g.lineTo(X(x), Y(y)) : g.moveTo(X(x), Y(y))));
      if (closed) g.closePath();
    };
    if (plan?.nominal.length) {
      const nominal: [number, number][] = [];
      for (let i = 0; i < plan.nominal.length; i += 2) nominal.push([plan.nominal[i], plan.nominal[i + 1]]);
      line(nominal, true);
      g.fillStyle = p.nominal;
      g.globalAlpha = 0.14;
      g.fill();
      g.globalAlpha = 1;
      g.strokeStyle = p.nominal;
      g.lineWidth = 1.25;
      g.stroke();
    }
    const whisker = (x: number, y: number, nx: number, ny: number, deviation: number) => {
      const reach = deviation * this.magnification;
      g.strokeStyle = deviationColour(deviation / halfLimit, p);
      g.beginPath();
      g.moveTo(X(x), Y(y));
      g.lineTo(X(x + nx * reach), Y(y + ny * reach));
      g.stroke();
    };
    g.lineWidth = 1.5;
    if (final?.contour.length) {
      let last = -Infinity, run = 0, before: number[] | null = null;
      // What was measured, in stretches from gap to gap.
      const rows = final.contour, behind = rows.findIndex((row, i) => row[6] !== null && rows[(i || rows.length) - 1][6] === null);
      const whole = behind < 0, tips: [number, number][][] = [[]], places: [number, number][][] = [[]];
      for (let i = 0; i < rows.length; ++i) {
        const [x, y, nx, ny, , deviation, u95] = rows[(i + Math.max(0, behind)) % rows.length];
        if (before) run += Math.hypot(x - before[0], y - before[1]) * v.scale;
        before = [x, y];
        if (u95 === null) {
          if (places[places.length - 1].length) { tips.push([]); places.push([]); }
          continue;
        }
        places[places.length - 1].push([x, y]);
        if (deviation === null) continue;
        const bx = x - nx * deviation, by = y - ny * deviation;
        tips[tips.length - 1].push([bx + nx * deviation * this.magnification, by + ny * deviation * this.magnification]);
        if (run - last < 6) continue;
        last = run;
        whisker(bx, by, nx, ny, deviation);
      }
      const compared = tips.some((stretch) => stretch.length);
      if (compared) {
        g.globalAlpha = 0.55;
        g.lineWidth = 1;
      }
      g.strokeStyle = compared ? p.ink : p.accent;
      for (const stretch of compared ? tips : places) {
        if (!stretch.length) continue;
        line(stretch, whole);
        g.stroke();
      }
      g.globalAlpha = 1;
    } else {
      for (const [, , x, y, touched, deviation, nx, ny] of live) {
        if (!touched || deviation === undefined || deviation === null || nx === undefined || ny === undefined) continue;
        const back = this.shown.ball + deviation;
        whisker(x - nx * back, y - ny * back, nx, ny, deviation);
      }
    }
    this.drawPoints(g, X, Y, p);
  }

  private drawPoints(g: CanvasRenderingContext2D, X: (x: number) => number, Y: (y: number) => number, p: Record<string, string>) {
    const spots = this.spots(), size = this.view().scale > 40 ? 2.4 : 1.2;
    g.fillStyle = p.soft;
    for (const spot of spots) if (spot.reason === 'none' || spot.reason === 'kept') g.fillRect(X(spot.x) - size / 2, Y(spot.y) - size / 2, size, size);
    g.lineWidth = 1.75;
    for (const spot of spots) {
      const x = X(spot.x), y = Y(spot.y);
      if (spot.reason === 'kept') {
        g.strokeStyle = p.good;
        g.strokeRect(x - 4, y - 4, 8, 8);
      } else if (spot.reason !== 'none') {
        g.strokeStyle = p.bad;
        g.beginPath();
        g.moveTo(x - 4, y - 4); g.lineTo(x + 4, y + 4); g.moveTo(x + 4, y - 4); g.lineTo(x - 4, y + 4);
        g.stroke();
      }
      if (spot.seq === this.shown.selected) {
        g.strokeStyle = p.accent;
        g.beginPath();
        g.arc(x, y, 9, 0, 2 * Math.PI);
        g.stroke();
      }
    }
    if (!this.shown.final && spots.length) {
      const tip = spots[spots.length - 1];
      g.strokeStyle = p.accent;
      g.fillStyle = p.accent;
      g.globalAlpha = 0.2;
      g.beginPath();
      g.arc(X(tip.x), Y(tip.y), Math.max(5, this.shown.ball * this.view().scale), 0, 2 * Math.PI);
      g.fill();
      g.globalAlpha = 1;
      g.stroke();
    }
  }
}
