// The Foxglove WebSocket protocol as the page speaks it: JSON texts and binary messages, without a socket.

export const kSubprotocols = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

export interface Channel {
  id: number;
  topic: string;
  encoding: string;
  schemaName: string;
  schema: string;
  schemaEncoding: string;
}

export interface ServerInfo {
  op: "serverInfo";
  name: string;
  sessionId: string;
  capabilities: string[];
  metadata: Record<string, string>;
}

export type ServerText =
  | ServerInfo
  | { op: "advertise"; channels: Channel[] }
  | { op: "unadvertise"; channelIds: number[] }
  | { op: "status"; level: number; message: string }
  | { op: "other" };

export type ServerBinary =
  | { kind: "message"; subscription: number; logTime_ns: bigint; payload: Uint8Array }
  | { kind: "time"; time_ns: bigint }
  | { kind: "other" };

const kMessageData = 0x01;
const kTime = 0x02;
const kMessageHead_bytes = 13;

/** Anything that is no message of the protocol is "other": a newer server may say more than this page knows. */
export function parseText(text: string): ServerText {
  let parsed: unknown;
  try {
    parsed = JSON.parse(text);
  } catch {
    return { op: "other" };
  }
  const op = (parsed as { op?: unknown } | null)?.op;
  if (op === "serverInfo" || op === "advertise" || op === "unadvertise" || op === "status") return parsed as ServerText;
  return { op: "other" };
}

export function parseBinary(data: ArrayBuffer): ServerBinary {
  const view = new DataView(data);
  if (view.byteLength >= kMessageHead_bytes && view.getUint8(0) === kMessageData) {
    return {
      kind: "message",
      subscription: view.getUint32(1, true),
      logTime_ns: view.getBigUint64(5, true),
      payload: new Uint8Array(data, kMessageHead_bytes),
    };
  }
  if (view.byteLength >= 9 && view.getUint8(0) === kTime) return { kind: "time", time_ns: view.getBigUint64(1, true) };
  return { kind: "other" };
}

export function subscribeText(subscriptions: { id: number; channelId: number }[]): string {
  return JSON.stringify({ op: "subscribe", subscriptions });
}

export function unsubscribeText(subscriptionIds: number[]): string {
  return JSON.stringify({ op: "unsubscribe", subscriptionIds });
}

/** The answer of GET /api/history: each message with its length (u32) before it. A torn end is left out. */
export function splitHistory(data: ArrayBuffer): ArrayBuffer[] {
  const view = new DataView(data);
  const messages: ArrayBuffer[] = [];
  for (let at = 0; at + 4 <= data.byteLength; ) {
    const length = view.getUint32(at, true);
    if (at + 4 + length > data.byteLength) break;
    messages.push(data.slice(at + 4, at + 4 + length));
    at += 4 + length;
  }
  return messages;
}

export function bytesFromBase64(text: string): Uint8Array<ArrayBuffer> {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}
