// Where a replay is, in seconds since the begin of its recording.
import type { PlayerState } from "./messages.ts";

export interface Position {
  begin_s: number; // on the session's axis
  length_s: number;
  at_s: number; // 0 to length_s
}

export function positionOf(state: PlayerState): Position {
  const begin_s = Number(state.begin_ns) * 1e-9;
  const length_s = Math.max(0, Number(state.end_ns) * 1e-9 - begin_s);
  const at_s = Math.min(length_s, Math.max(0, Number(state.position_ns) * 1e-9 - begin_s));
  return { begin_s, length_s, at_s };
}
