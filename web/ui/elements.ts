// What the page is put together from: elements with their texts, and how a characteristic is written for people.
import type { Budget, Characteristic } from './documents';
import { type Word, decisionMark, decisionWord, say } from './words';

export function make<K extends keyof HTMLElementTagNameMap>(tag: K, text = '', name = ''): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  if (text) element.textContent = text;
  if (name) element.className = name;
  return element;
}

export function badge(decision: string): HTMLElement {
  const element = make('span', '', 'badge ' + decision);
  const mark = make('span', decisionMark[decision] ?? '·', 'mark');
  mark.setAttribute('aria-hidden', 'true');
  element.append(mark, decisionWord(decision));
  return element;
}

export function cells(row: HTMLTableRowElement, texts: (string | HTMLElement)[], numbers: number[] = []) {
  texts.forEach((text, i) => {
    const cell = make('td', '', numbers.includes(i) ? 'number' : '');
    cell.append(text);
    row.append(cell);
  });
}

/** A text with another below it. */
export function withSmall(tag: 'span' | 'th', text: string, below: string): HTMLElement {
  const element = make(tag, text);
  if (below) element.append(make('small', below));
  return element;
}

/** For people: angles in degrees. */
export function shown(c: Characteristic, value: number | null, digits: number): string {
  if (value === null) return '';
  if (c.unit === '1' && Number.isInteger(value)) return String(value); // a count
  const symbol = { mm: '', rad: '°', mm2: ' mm²', '1/mm': ' 1/mm', '1': '' }[c.unit];
  return (c.unit === 'rad' ? (value * 180) / Math.PI : value).toFixed(digits) + symbol;
}

export function limits(c: Characteristic): string {
  if (c.lower === null) return c.upper === null ? '' : '≤\u00a0' + shown(c, c.upper, 3);
  return c.upper === null ? '≥\u00a0' + shown(c, c.lower, 3) : shown(c, c.lower, 3) + '\u00a0… ' + shown(c, c.upper, 3);
}

/** The value with U95 below it; where that is known, what most of it comes from, and in the tip all of it. */
export function withUncertainty(c: Characteristic): HTMLElement {
  const u95 = shown(c, c.u95, 4);
  const element = withSmall('span', shown(c, c.value, 4) || '–', u95 && '±\u00a0' + u95);
  if (!c.budget || !u95) return element;
  const parts = (Object.keys(c.budget) as (keyof Budget)[]).map((key) => [say(`budget_${key}` as Word), c.budget![key]] as const);
  element.title = [say('budget'), ...parts.map(([name, value]) => `${name}: ${shown(c, value, 5)}`)].join('\n');
  element.append(make('small', parts.reduce((most, part) => (part[1] > most[1] ? part : most))[0]));
  return element;
}
