// The stacked sections in space, coloured by deviation; sections still to come are thin lines.
import type { PlanSection, Section } from './documents';
import { begin, deviationColour, palette } from './canvas';

interface Ring { x: Float64Array; y: Float64Array; z: number; share: Float64Array | null }
const corners = 180;

/** Even in arc length from the corner nearest to `start`. Deviations: NaN in a gap. */
function ring(points: [number, number][], z: number, start: [number, number], deviations: (number | null)[] | null, halfLimit: number): Ring {
  const n = points.length, lengths = new Float64Array(n + 1);
  let first = 0, nearest = Infinity;
  points.forEach(([x, y], i) => {
    const d = Math.hypot(x - start[0], y - start[1]);
    if (d < nearest) { nearest = d; first = i; }
  });
  const at = (i: number) => points[(i + first) % n];
  for (let i = 0; i < n; ++i) lengths[i + 1] = lengths[i] + Math.hypot(at(i + 1)[0] - at(i)[0], at(i + 1)[1] - at(i)[1]);
  const out: Ring = { x: new Float64Array(corners), y: new Float64Array(corners), z, share: deviations ? new Float64Array(corners) : null };
  for (let k = 0, i = 0; k < corners; ++k) {
    const s = (lengths[n] * k) / corners;
    while (i < n - 1 && lengths[i + 1] <= s) ++i;
    const t = (s - lengths[i]) / (lengths[i + 1] - lengths[i] || 1), [ax, ay] = at(i), [bx, by] = at(i + 1);
    out.x[k] = ax + (bx - ax) * t;
    out.y[k] = ay + (by - ay) * t;
    if (out.share && deviations) out.share[k] = (deviations[(i + first) % n] ?? 0) / halfLimit;
  }
  return out;
}

/** The same ring begun so that its corners lie opposite those of the ring below, each seen from its own middle: which end
 *  of a section is the LE may be told differently from section to section, and facets between unlike places would cross. */
function opposite(below: Ring, above: Ring): Ring {
  const mean = (v: Float64Array) => v.reduce((sum, c) => sum + c, 0) / corners;
  const dx = mean(above.x) - mean(below.x), dy = mean(above.y) - mean(below.y);
  let best = 0, least = Infinity;
  for (let shift = 0; shift < corners; ++shift) {
    let sum = 0;
    for (let k = 0; k < corners; ++k) {
      const l = (k + shift) % corners;
      sum += (above.x[l] - dx - below.x[k]) ** 2 + (above.y[l] - dy - below.y[k]) ** 2;
    }
    if (sum < least) { least = sum; best = shift; }
  }
  const begun = (v: Float64Array) => v.map((_, k) => v[(k + best) % corners]);
  return { x: begun(above.x), y: begun(above.y), z: above.z, share: above.share && begun(above.share) };
}

export class BladeView {
  private turn = -0.9;
  private tilt = 0.42;
  private rings: Ring[] = [];
  private measured: Ring[] = [];
  current = -1;
  constructor(readonly canvas: HTMLCanvasElement) {
    let from: [number, number] | null = null;
    canvas.addEventListener('pointerdown', (e) => { from = [e.offsetX, e.offsetY]; canvas.setPointerCapture(e.pointerId); });
    canvas.addEventListener('pointerup', () => { from = null; });
    canvas.addEventListener('pointermove', (e) => {
      if (!from) return;
      this.rotate((e.offsetX - from[0]) * 0.01, (e.offsetY - from[1]) * 0.01);
      from = [e.offsetX, e.offsetY];
    });
    canvas.addEventListener('keydown', (e) => {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[e.key];
      if (!step) return;
      e.preventDefault();
      e.stopPropagation();
      this.rotate(step[0], step[1]);
    });
  }
  private rotate(turn: number, tilt: number) {
    this.turn += turn;
    this.tilt = Math.max(-1.5, Math.min(1.5, this.tilt + tilt));
    this.draw();
  }
  show(plan: PlanSection[], sections: Map<number, Section>, halfLimit: number) {
    const start = (s: Section | undefined, nominal: [number, number][]): [number, number] =>
      s?.le ?? nominal.reduce((best, p) => (p[0] - p[1] < best[0] - best[1] ? p : best), nominal[0] ?? [0, 0]);
    this.rings = [];
    this.measured = [];
    for (const planned of plan) {
      const nominal: [number, number][] = [];
      for (let i = 0; i < planned.nominal.length; i += 2) nominal.push([planned.nominal[i], planned.nominal[i + 1]]);
      const final = sections.get(planned.index);
      if (final?.contour.length) {
        this.measured.push(ring(final.contour.map(([x, y]) => [x, y]), planned.z_mm, start(final, nominal), final.contour.map((row) => (row[6] === null ? NaN : row[5])), halfLimit));
      } else if (nominal.length) {
        this.rings.push(ring(nominal, planned.z_mm, start(undefined, nominal), null, halfLimit));
      }
    }
    this.measured.sort((a, b) => a.z - b.z);
    for (let i = 1; i < this.measured.length; ++i) this.measured[i] = opposite(this.measured[i - 1], this.measured[i]);
    this.draw();
  }
  draw() {
    const frame = begin(this.canvas);
    if (!frame) return;
    const { g, width, height } = frame, p = palette(), all = [...this.measured, ...this.rings];
    if (!all.length) return;
    const middle = [0, 0, 0], low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const one of all) for (let k = 0; k < corners; ++k) [one.x[k], one.y[k], one.z].forEach((c, i) => { low[i] = Math.min(low[i], c); high[i] = Math.max(high[i], c); });
    low.forEach((c, i) => { middle[i] = (c + high[i]) / 2; });
    const [ct, st, cl, sl] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.tilt), Math.sin(this.tilt)];
    const turned = (x: number, y: number, z: number): [number, number, number] => {
      const [dx, dy, dz] = [x - middle[0], y - middle[1], z - middle[2]];
      const across = dx * ct - dy * st, deep = dx * st + dy * ct;
      return [across, dz * cl - deep * sl, deep * cl + dz * sl];
    };
    let wide = 1e-3, tall = 1e-3;
    for (const one of all) for (let k = 0; k < corners; ++k) {
      const [a, b] = turned(one.x[k], one.y[k], one.z);
      wide = Math.max(wide, Math.abs(a));
      tall = Math.max(tall, Math.abs(b));
    }
    const scale = Math.min((width / 2 - 10) / wide, (height / 2 - 10) / tall);
    const project = (x: number, y: number, z: number): [number, number, number] => {
      const [a, b, depth] = turned(x, y, z);
      return [width / 2 + a * scale, height / 2 - b * scale, depth];
    };
    const outline = (one: Ring, colour: string, thick: number) => {
      g.strokeStyle = colour;
      g.lineWidth = thick;
      g.beginPath();
      for (let k = 0; k < corners; ++k) {
        const [x, y] = project(one.x[k], one.y[k], one.z);
        if (k) g.lineTo(x, y); else g.moveTo(x, y);
      }
      g.closePath();
      g.stroke();
    };
    interface Facet { depth: number; shape: [number, number, number][]; share: number; light: number }
    const facets: Facet[] = [];
    for (let i = 0; i + 1 < this.measured.length; ++i) {
      const [a, b] = [this.measured[i], this.measured[i + 1]];
      for (let k = 0; k < corners; ++k) {
        const l = (k + 1) % corners;
        const share = ((a.share?.[k] ?? 0) + (a.share?.[l] ?? 0) + (b.share?.[l] ?? 0) + (b.share?.[k] ?? 0)) / 4;
        if (Number.isNaN(share)) continue;
        const shape = [project(a.x[k], a.y[k], a.z), project(a.x[l], a.y[l], a.z), project(b.x[l], b.y[l], b.z), project(b.x[k], b.y[k], b.z)];
        const ex = a.x[l] - a.x[k], ey = a.y[l] - a.y[k], across = (ey * ct + ex * st) / (Math.hypot(ex, ey) || 1);
        facets.push({
          depth: shape.reduce((sum, q) => sum + q[2], 0), shape, light: 0.86 + 0.14 * across, share });
      }
    }
    facets.sort((a, b) => b.depth - a.depth);
    for (const facet of facets) {
      const colour = deviationColour(facet.share, p);
      g.fillStyle = colour;
      g.strokeStyle = colour;
      g.lineWidth = 0.7;
      g.beginPath();
      facet.shape.forEach(([x, y], i) => (i ? g.lineTo(x, y) : g.moveTo(x, y)));
      g.closePath();
      g.fill();
      g.stroke();
      g.globalAlpha = 1 - facet.light;
      g.fillStyle = '#000';
      g.fill();
      g.globalAlpha = 1;
    }
    for (const one of this.rings) outline(one, p.nominal, 1);
    for (const one of this.measured) outline(one, p.ink + '66', 1);
  }
}
