// Deviation along the section, with the limits and what the uncertainty leaves open.
import type { LivePoint, Plan, Section } from './documents';
import { begin, length, palette } from './canvas';
import { say } from './words';

const zones = ['zone_le', 'zone_suction', 'zone_te', 'zone_pressure'] as const;

interface Station { s: number; deviation: number | null; u95: number; zone: number; below?: number; above?: number }

function stations(final: Section | undefined, live: LivePoint[]): Station[] {
  if (final?.contour.length) {
    // From the first point of a zone on, so that no zone is drawn in two parts.
    const rows = final.contour, turn = Math.max(0, rows.findIndex((row, i) => i > 0 && row[4] !== rows[i - 1][4]));
    let s = 0;
    return rows.map((_, i) => {
      const row = rows[(i + turn) % rows.length], before = rows[(i + turn + rows.length - 1) % rows.length];
      if (i) s += Math.hypot(row[0] - before[0], row[1] - before[1]);
      return { s, deviation: row[5], u95: row[6] ?? 0, zone: row[4], below: row[7], above: row[8] };
    });
  }
  let s = 0;
  return live.map((point, i) => {
    if (i) s += Math.hypot(point[2] - live[i - 1][2], point[3] - live[i - 1][3]);
    return { s, deviation: point[5] ?? null, u95: 0, zone: -1 };
  });
}

export function drawStrip(canvas: HTMLCanvasElement, plan: Plan | null, final: Section | undefined, live: LivePoint[], expected: number) {
  const frame = begin(canvas);
  if (!frame) return;
  const { g, width, height } = frame, p = palette(), all = stations(final, live);
  const left = 72, right = 8, top = 18, bottom = 18, so_far = all.length ? all[all.length - 1].s || 1 : 1;
  const end = final ? so_far : so_far * Math.max(1, expected / Math.max(1, all.length));
  const half = (zone: number) => ((zone === 0 || zone === 2 ? plan?.edge_profile_mm : plan?.profile_mm) ?? NaN) / 2;
  const widest = all.reduce((most, one) => Math.max(most, -(one.below ?? 0), one.above ?? 0), 0);
  const limit = Math.max(...[half(0), half(1), widest].filter(Number.isFinite), 0.005);
  const sorted = all.map((one) => Math.abs(one.deviation ?? 0)).sort((a, b) => a - b);
  // A few bad points must not flatten the rest.
  const largest = final ? (sorted[sorted.length - 1] ?? 0) : (sorted[Math.floor(sorted.length * 0.98)] ?? 0);
  const range = Math.max(limit * 1.25, Math.min(largest * 1.1, limit * 6));
  const X = (s: number) => left + ((width - left - right) * s) / end;
  const Y = (d: number) => top + ((height - top - bottom) * (range - Math.max(-range, Math.min(range, d)))) / (2 * range);
  g.fillStyle = p.soft;
  g.textAlign = 'right';
  g.textBaseline = 'middle';
  g.lineWidth = 1;
  for (const d of [-limit, 0, limit]) {
    g.strokeStyle = p.line;
    g.beginPath(); g.moveTo(left, Y(d)); g.lineTo(width - right, Y(d)); g.stroke();
    g.fillText((d > 0 ? '+' : '') + length(d), left - 6, Y(d));
  }
  if (!all.length) return;
  if (final) drawZones(g, all, p, X, Y, half, height, bottom, width - right);
  if (widest) drawPointLimits(g, all, p, X, Y);
  g.fillStyle = p.accent;
  g.globalAlpha = 0.25;
  for (const one of all) if (one.deviation !== null && one.u95) g.fillRect(X(one.s), Y(one.deviation + one.u95), 1.2, Y(one.deviation - one.u95) - Y(one.deviation + one.u95));
  g.globalAlpha = 1;
  if (!final) {
    g.fillStyle = p.accent;
    for (const one of all) if (one.deviation !== null) g.fillRect(X(one.s) - 1, Y(one.deviation) - 1, 2, 2);
  } else {
    g.strokeStyle = p.ink;
    g.lineWidth = 1.4;
    g.beginPath();
    let pen = false;
    for (const one of all) {
      if (one.deviation === null) { pen = false; continue; }
      if (pen) g.lineTo(X(one.s), Y(one.deviation)); else g.moveTo(X(one.s), Y(one.deviation));
      pen = true;
    }
    g.stroke();
  }
}

/** Limits that differ from point to point. */
function drawPointLimits(g: CanvasRenderingContext2D, all: Station[], p: Record<string, string>, X: (s: number) => number, Y: (d: number) => number) {
  g.strokeStyle = p.bad;
  g.setLineDash([5, 3]);
  for (const side of ['below', 'above'] as const) {
    g.beginPath();
    let pen = false;
    for (const one of all) {
      const limit = one[side];
      if (limit === undefined) { pen = false; continue; }
      if (pen) g.lineTo(X(one.s), Y(limit)); else g.moveTo(X(one.s), Y(limit));
      pen = true;
    }
    g.stroke();
  }
  g.setLineDash([]);
}

function drawZones(g: CanvasRenderingContext2D, all: Station[], p: Record<string, string>, X: (s: number) => number, Y: (d: number) => number,
                   half: (zone: number) => number, height: number, bottom: number, rightmost: number) {
  let from = 0;
  g.textBaseline = 'alphabetic';
  g.textAlign = 'center';
  for (let i = 1; i <= all.length; ++i) {
    if (i < all.length && all[i].zone === all[from].zone) continue;
    const a = X(all[from].s), b = i < all.length ? X(all[i].s) : rightmost, limit = half(all[from].zone);
    if (Number.isFinite(limit)) {
      g.strokeStyle = p.bad;
      g.setLineDash([5, 3]);
      for (const d of [-limit, limit]) { g.beginPath(); g.moveTo(a, Y(d)); g.lineTo(b, Y(d)); g.stroke(); }
      g.setLineDash([]);
    }
    g.strokeStyle = p.line;
    g.beginPath(); g.moveTo(a, 6); g.lineTo(a, height - bottom); g.stroke();
    g.fillStyle = p.soft;
    const text = say(zones[all[from].zone] ?? 'zone_le');
    if (b - a > g.measureText(text).width + 4) g.fillText(text, (a + b) / 2, height - 5);
    from = i;
  }
}
