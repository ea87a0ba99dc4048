// What the server sends (docs/page.md). Millimetres, part frame.
export type Decision = 'accept' | 'reject' | 'undecided' | 'reported' | 'not_evaluable' | 'done';
export interface PlanSection { index: number; z_mm: number; nominal: number[] }
export interface Plan {
  id: string; run_id: string; part: string; serial: string; machine: string; started_utc: string; has_nominal: boolean;
  ball_radius_mm: number; profile_mm: number | null; edge_profile_mm: number | null; sections: PlanSection[];
}
/** seq, section, x, y, touched, and against a nominal: deviation, normal x, normal y. */
export type LivePoint = [number, number, number, number, number, (number | null)?, number?, number?];
export interface Points { last: number; more: boolean; points: LivePoint[] }
/** x, y, normal x, normal y, zone (0 LE, 1 suction, 2 TE, 3 pressure), deviation, U95 (null: not measured, a gap); where the nominal has tolerances
 *  at its points: lowest and highest deviation that conform here. */
export type ContourRow = [number, number, number, number, number, number | null, number | null, number?, number?];
/** seq, x, y, what became of it, residual. */
export type JudgedPoint = [number, number, number, string, number];
/** Standard uncertainties by where they come from; `added` is added to U95 as it is. In the unit of their number. */
export interface Budget { noise: number; ball: number; probing: number; length: number; temperature: number; added: number }
/** value_mm, u95_mm, limit_mm: of lengths; the others in `unit`. `budget`: where machine or temperature are known. */
export interface Characteristic {
  name: string; value_mm: number | null; u95_mm: number | null; limit_mm: number | null; decision: Decision; method: string; note: string;
  unit: 'mm' | 'rad' | 'mm2' | '1/mm' | '1'; value: number | null; u95: number | null; nominal: number | null; lower: number | null; upper: number | null; budget?: Budget;
}
export interface Section {
  index: number; name: string; z_mm: number; finished: boolean; closed: boolean; decision: Decision; rejected: number; why: string;
  noise_mm?: number; le?: [number, number] | null; te?: [number, number] | null;
  characteristics: Characteristic[]; contour: ContourRow[]; points: JudgedPoint[];
}
/** Needs several sections; `section` null: of the whole part. */
export interface PartCharacteristic extends Characteristic { section: number | null }
export interface Choice { rejected: number[]; restored: number[] }
export interface Result {
  id: string; choice: Choice;
  result: { verdict: Decision; reasons: string[]; run: { complete: boolean }; sections: { index: number; decision: Decision }[]; characteristics: PartCharacteristic[] };
}
export interface Link {
  exchanges: number; errors: number; retries: number; reconnects: number; bytes_received: number; mean_round_trip_ms: number;
  max_round_trip_ms: number; note?: string;
}
export interface Status {
  version: string;
  job: null | { id: string; running: boolean; may_stop: boolean; share?: number; text?: string; link?: Link };
}
export interface Worst { value_mm: number; u95_mm: number | null; limit_mm: number | null; decision: Decision; section: number }
export interface RunSummary {
  id: string; part?: string; serial?: string; started_utc?: string; machine?: string; complete?: boolean; verdict?: Decision;
  sections?: number; worst?: Record<string, Worst>; problem?: string;
}
export interface RunEvent { seq?: number; event: string; t_machine_s?: number; t_host_s?: number; [field: string]: unknown }
