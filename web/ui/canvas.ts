// Canvases in device pixels, and the colours of the present theme.
export interface Palette { [name: string]: string }
export function palette(): Palette {
  const style = getComputedStyle(document.documentElement);
  const names = ['ink', 'soft', 'line', 'card', 'nominal', 'good', 'bad', 'doubt', 'low', 'mid', 'high', 'accent'];
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue('--' + name).trim()]));
}

/** Cleared and scaled to CSS pixels; nothing while it has no size. */
export function begin(canvas: HTMLCanvasElement): { g: CanvasRenderingContext2D; width: number; height: number } | null {
  const width = canvas.clientWidth, height = canvas.clientHeight;
  const g = canvas.getContext('2d');
  if (!g || !width || !height) return null;
  const ratio = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  g.setTransform(ratio, 0, 0, ratio, 0, 0);
  g.clearRect(0, 0, width, height);
  g.font = '12px system-ui, sans-serif';
  g.lineJoin = 'round';
  return { g, width, height };
}

const mixed = new Map<string, string>();
const channels = (hex: string) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
/** Too little material is `low`, too much is `high`: share of the limit, from -1 to 1. */
export function deviationColour(share: number, p: Palette): string {
  const step = Math.round(Math.max(-1, Math.min(1, share)) * 16);
  const key = `${step}${p.low}${p.mid}${p.high}`;
  let colour = mixed.get(key);
  if (!colour) {
    const from = channels(p.mid), to = channels(step < 0 ? p.low : p.high), t = Math.abs(step) / 16;
    colour = `rgb(${from.map((c, i) => Math.round(c + (to[i] - c) * t)).join(',')})`;
    mixed.set(key, colour);
  }
  return colour;
}

/** The largest of 1, 2, 5 times a power of ten that is not above. */
export function roundDown(value: number): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const digit = value / power;
  return (digit >= 5 ? 5 : digit >= 2 ? 2 : 1) * power;
}
/** Millimetres for people: micrometres below a tenth. */
export function length(mm: number): string {
  return Math.abs(mm) < 0.0995 ? (mm * 1000).toFixed(1) + ' µm' : mm.toFixed(3) + ' mm';
}
