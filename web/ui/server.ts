// Requests to the server and the stream of events, with the token where there is one.
import type { RunEvent } from './documents';

const store = 'cmmlive.token';

/** Of the address (the fragment is not sent to anybody, and is taken away at once) or of this tab. */
export function takeToken(): string {
  const shown = /(?:^#|&)token=([A-Za-z0-9_-]+)/.exec(location.hash);
  if (shown) {
    sessionStorage.setItem(store, shown[1]);
    history.replaceState(null, '', location.pathname + location.search + location.hash.replace(/&?token=[^&]*/, '').replace(/^#$/, ''));
  }
  return sessionStorage.getItem(store) ?? '';
}
let token = '';
export function useToken(text: string) {
  token = text;
  if (text) sessionStorage.setItem(store, text);
  else sessionStorage.removeItem(store);
}

export class Refused extends Error {
  constructor(readonly status: number, message: string) { super(message); }
}

async function answer<T>(response: Response): Promise<T> {
  const text = await response.text();
  if (response.ok) return JSON.parse(text) as T;
  let why = response.statusText;
  try { why = (JSON.parse(text) as { error: string }).error; } catch { /* the status says it */ }
  throw new Refused(response.status, why);
}
const headers = (): Record<string, string> => (token ? { Authorization: 'Bearer ' + token } : {});

export const get = async <T>(path: string) => answer<T>(await fetch(path, { headers: headers(), cache: 'no-store' }));
export const post = async <T>(path: string, body: unknown) =>
  answer<T>(await fetch(path, {
    method: 'POST', headers: { ...headers(), 'Content-Type': 'application/json' }, body: JSON.stringify(body),
  }));

/** Events of one run from a sequence on, until closed; `lost` when the connection ends. */
export class EventStream {
  private socket: WebSocket;
  constructor(run: string, from: number, take: (events: RunEvent[]) => void, open: () => void, lost: () => void) {
    const address = `ws${location.protocol === 'https:' ? 's' : ''}://${location.host}/api/events?run=${encodeURIComponent(run)}&from=${from}`;
    this.socket = token ? new WebSocket(address, 'cmmlive.token.' + token) : new WebSocket(address);
    this.socket.onopen = open;
    this.socket.onmessage = (message) => take(String(message.data).split('\n').map((line) => JSON.parse(line) as RunEvent));
    this.socket.onclose = lost;
  }
  close() {
    this.socket.onclose = null;
    this.socket.close();
  }
}
