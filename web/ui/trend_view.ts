// One characteristic over the runs: its worst section, with uncertainty and limit.
import type { RunSummary } from './documents';
import { begin, length, palette } from './canvas';

export function drawTrend(canvas: HTMLCanvasElement, runs: RunSummary[], name: string) {
  const frame = begin(canvas);
  if (!frame) return;
  const { g, width, height } = frame, p = palette();
  const shown = runs.filter((run) => run.worst?.[name]).sort((a, b) => (a.started_utc ?? '').localeCompare(b.started_utc ?? ''));
  if (!shown.length) return;
  const values = shown.map((run) => run.worst![name]);
  const ends = values.flatMap((v) => [v.value_mm - (v.u95_mm ?? 0), v.value_mm + (v.u95_mm ?? 0), ...(v.limit_mm ? [v.limit_mm] : [])]);
  let low = Math.min(...ends), high = Math.max(...ends);
  const margin = (high - low || high * 0.1 || 1) * 0.15;
  low = low >= 0 ? Math.max(0, low - margin) : low - margin;
  high += margin;
  const left = 78, right = 14;
  const X = (i: number) => (shown.length > 1 ? left + ((width - left - right) * (i + 0.5)) / shown.length : (width + left) / 2);
  const Y = (v: number) => 10 + ((height - 24) * (high - v)) / (high - low);
  g.fillStyle = p.soft;
  g.textAlign = 'right';
  g.textBaseline = 'middle';
  for (const v of [low, high - margin]) g.fillText(length(v), left - 8, Y(v));
  const limit = values[values.length - 1].limit_mm;
  if (limit) {
    g.strokeStyle = p.bad;
    g.setLineDash([5, 3]);
    g.beginPath(); g.moveTo(left, Y(limit)); g.lineTo(width - right, Y(limit)); g.stroke();
    g.setLineDash([]);
  }
  g.strokeStyle = p.line;
  g.beginPath();
  values.forEach((v, i) => (i ? g.lineTo(X(i), Y(v.value_mm)) : g.moveTo(X(i), Y(v.value_mm))));
  g.stroke();
  values.forEach((v, i) => {
    const colour = { accept: p.good, reject: p.bad, undecided: p.doubt }[v.decision as string] ?? p.soft, u = v.u95_mm ?? 0;
    g.strokeStyle = colour;
    g.fillStyle = colour;
    g.lineWidth = 1.5;
    g.beginPath(); g.moveTo(X(i), Y(v.value_mm - u)); g.lineTo(X(i), Y(v.value_mm + u)); g.stroke();
    g.beginPath();
    if (v.decision === 'reject') g.rect(X(i) - 4, Y(v.value_mm) - 4, 8, 8);
    else if (v.decision === 'undecided') { g.moveTo(X(i), Y(v.value_mm) - 5); g.lineTo(X(i) + 5, Y(v.value_mm) + 4); g.lineTo(X(i) - 5, Y(v.value_mm) + 4); g.closePath(); }
    else g.arc(X(i), Y(v.value_mm), 4, 0, 2 * Math.PI);
    g.fill();
  });
}
