import assert from "node:assert/strict";
import { test } from "node:test";
import { bytesFromBase64, parseBinary, parseText, splitHistory, subscribeText } from "../src/protocol/codec.ts";
import { decoderFor } from "../src/protocol/decoder.ts";
import type { Wind } from "../src/model/messages.ts";

function message(subscription: number, time: bigint, payload: number[]): ArrayBuffer {
  const data = new DataView(new ArrayBuffer(13 + payload.length));
  data.setUint8(0, 1);
  data.setUint32(1, subscription, true);
  data.setBigUint64(5, time, true);
  payload.forEach((byte, i) => data.setUint8(13 + i, byte));
  return data.buffer;
}

test("reads messages", () => {
  const read = parseBinary(message(0xfffffffe, 123456789012345678n, [7, 8]));
  assert.equal(read.kind, "message");
  if (read.kind !== "message") return;
  assert.equal(read.subscription, 0xfffffffe);
  assert.equal(read.logTime_ns, 123456789012345678n);
  assert.deepEqual([...read.payload], [7, 8]);
});

test("reads the time", () => {
  const data = new DataView(new ArrayBuffer(9));
  data.setUint8(0, 2);
  data.setBigUint64(1, 42n, true);
  assert.deepEqual(parseBinary(data.buffer), { kind: "time", time_ns: 42n });
});

test("takes nonsense for something else", () => {
  for (const bytes of [[], [1], [1, 2, 3], [9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9]]) {
    assert.equal(parseBinary(new Uint8Array(bytes).buffer).kind, "other");
  }
  for (const text of ["", "null", "7", "[]", "{", '{"op":"parameterValues"}', '{"op":3}']) {
    assert.equal(parseText(text).op, "other");
  }
});

test("reads server texts", () => {
  const info = parseText('{"op":"serverInfo","name":"roseau","sessionId":"s","capabilities":[],"metadata":{"mode":"live"}}');
  assert.ok(info.op === "serverInfo" && info.metadata["mode"] === "live");
});

test("writes subscriptions as the protocol spells them", () => {
  assert.deepEqual(JSON.parse(subscribeText([{ id: 1, channelId: 9 }])), {
    op: "subscribe",
    subscriptions: [{ id: 1, channelId: 9 }],
  });
});

test("splits history and leaves out a torn end", () => {
  const one = new Uint8Array(message(0, 5n, [1]));
  const all = new Uint8Array(2 * (4 + one.length) + 6);
  const view = new DataView(all.buffer);
  for (const at of [0, 4 + one.length]) {
    view.setUint32(at, one.length, true);
    all.set(one, at + 4);
  }
  view.setUint32(2 * (4 + one.length), 99, true);
  const pieces = splitHistory(all.buffer);
  assert.equal(pieces.length, 2);
  assert.deepEqual([...new Uint8Array(pieces[1]!)], [...one]);
  assert.deepEqual(splitHistory(new ArrayBuffer(0)), []);
});

test("reads base64", () => {
  assert.deepEqual([...bytesFromBase64("//77")], [255, 254, 251]);
});

// FileDescriptorSet of: syntax = "proto3"; package roseau; message Wind { double u_mps = 3; bool valid = 9; }
const kWindSchema =
  "Cj8KB3cucHJvdG8SBnJvc2VhdSIkCgRXaW5kEg0KBXVfbXBzGAMgASgBEg0KBXZhbGlkGAkgASgIYgZwcm90bzM=";

test("decodes by the advertised schema", () => {
  const channel = { id: 1, topic: "/w", encoding: "protobuf", schemaName: "roseau.Wind", schema: kWindSchema, schemaEncoding: "protobuf" };
  const decode = decoderFor(channel);
  assert.ok(decode);
  // Field 3: double 2.5; field 9: true; field 15, unknown to the schema: 1.
  const wind = decode(new Uint8Array([0x19, 0, 0, 0, 0, 0, 0, 4, 0x40, 0x48, 1, 0x78, 1])) as Wind;
  assert.equal(wind.uMps, 2.5);
  assert.equal(wind.valid, true);
});

test("decodes json, and refuses what it cannot read", () => {
  const base = { id: 1, topic: "/s", schemaName: "x", schema: "", schemaEncoding: "jsonschema" };
  const decode = decoderFor({ ...base, encoding: "json" });
  assert.deepEqual(decode?.(new TextEncoder().encode('{"clients":2}')), { clients: 2 });
  assert.equal(decoderFor({ ...base, encoding: "cdr" }), undefined);
  assert.equal(decoderFor({ ...base, encoding: "protobuf", schemaEncoding: "protobuf", schema: "AAAA" }), undefined);
});
