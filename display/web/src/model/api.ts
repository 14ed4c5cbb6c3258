// What the page asks of the daemon, and what it may do there (POST; the answer is {} or {"error": words}).
import { splitHistory } from "../protocol/codec.ts";
import type { ImageRect, StreamInfo } from "./messages.ts";

export type Action =
  | { kind: "mark"; text?: string }
  | { kind: "note"; text: string }
  | { kind: "add_target"; text: string; camera: string; region: ImageRect }
  | { kind: "remove_target"; text: string; camera: string }
  | { kind: "trigger"; text?: string }
  | { kind: "start_recording" | "stop_recording" };

export type PlayerCommand =
  | { command: "play" | "pause" }
  | { command: "speed"; speed: number | null }
  | { command: "seek"; time_s: number }; // since the begin of the recording

/** GET /api/marks: of the recording that is replayed. */
export interface RecordedMark {
  time_ns: string;
  text: string;
}

/** Nothing when done, else what went wrong, in words for the operator. */
async function post(path: string, body: unknown): Promise<string | undefined> {
  try {
    const response = await fetch(path, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(body),
      signal: AbortSignal.timeout(3000),
    });
    if (response.ok) return undefined;
    const answer = (await response.json()) as { error?: string };
    return answer.error ?? `the daemon answered ${response.status}`;
  } catch {
    return "the daemon does not answer: nothing was done. Check that roseau is running and the network is up";
  }
}

export const act = (action: Action): Promise<string | undefined> => post("api/action", action);
export const play = (command: PlayerCommand): Promise<string | undefined> => post("api/player", command);

export async function fetchStreams(): Promise<StreamInfo[]> {
  const response = await fetch("api/streams");
  return ((await response.json()) as { streams: StreamInfo[] }).streams;
}

export async function fetchMarks(): Promise<RecordedMark[]> {
  const response = await fetch("api/marks");
  return ((await response.json()) as { marks: RecordedMark[] }).marks;
}

export async function fetchHistory(channel: number): Promise<ArrayBuffer[]> {
  const response = await fetch(`api/history?channel=${channel}`);
  return response.ok ? splitHistory(await response.arrayBuffer()) : [];
}
