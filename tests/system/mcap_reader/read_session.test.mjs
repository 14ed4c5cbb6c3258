// A session written by our recorder, read by an independent MCAP reader with its CRC checks on, every message decoded with
// nothing but the schemas in the file.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { createFileRegistry, fromBinary, toJson } from "@bufbuild/protobuf";
import { FileDescriptorSetSchema } from "@bufbuild/protobuf/wkt";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";

const decompressHandlers = await loadDecompressHandlers();
const BEGIN_NS = 200_000_000_000_000n;

const inMemory = (bytes) => ({
  size: async () => BigInt(bytes.length),
  read: async (offset, length) => bytes.subarray(Number(offset), Number(offset + length)),
});

const openIndexed = (bytes) => McapIndexedReader.Initialize({ readable: inMemory(bytes), decompressHandlers });

async function collect(generator) {
  const all = [];
  for await (const one of generator) all.push(one);
  return all;
}

// Decodes messages of one channel by the descriptor set in the file.
function decoderOf(schema) {
  assert.equal(schema.encoding, "protobuf");
  const registry = createFileRegistry(fromBinary(FileDescriptorSetSchema, schema.data));
  const type = registry.getMessage(schema.name);
  assert.ok(type, `${schema.name} is not in its own descriptor set`);
  return (data) => toJson(type, fromBinary(type, data), { registry });
}

// What tests/support/samples.h puts into each kind, as far as a reader would look.
const EXPECTED = {
  "/test/raw_bytes": { schema: "roseau.RawBytes", fields: { lineErrors: 3, byteTime: "0.000086806s" } },
  "/test/frame": { schema: "foxglove.RawImage", fields: { width: 5, height: 3, step: 8, encoding: "mono8", frameId: "camera0" } },
  "/test/camera_calibration": {
    schema: "foxglove.CameraCalibration",
    fields: { width: 1280, K: [1500.5, 0, 640.25, 0, 1501.5, 512.75, 0, 0, 1], distortionModel: "plumb_bob" },
  },
  "/test/operator_action": { schema: "roseau.OperatorAction", fields: { kind: "ADD_TARGET", text: "branch" } },
  "/test/skip": { schema: "roseau.Skip", fields: { topic: "/camera0/image", sequence: 17 } },
  "/test/wind": { schema: "roseau.Wind", fields: { uMps: 1.5, vMps: -2.5, sonicTemperatureCelsius: 21.125, valid: true } },
  "/test/displacement": { schema: "roseau.Displacement", fields: { x: 1.25, unit: "STRAIN", health: 0.75 } },
  "/test/image_motion": { schema: "foxglove.ImageAnnotations", fields: {} },
  "/test/identification": { schema: "roseau.Identification", fields: { naturalFrequencyHz: 2.25, axis: { x: 0.8, y: 0.6 } } },
  "/test/wind_estimate": { schema: "roseau.WindEstimate", fields: { windMps: 3.5, settling: true } },
  "/test/wind_calibration": { schema: "roseau.WindCalibration", fields: { reference: "/sonic/wind", exponent: 2 } },
  "/test/force_spectrum": { schema: "roseau.ForceSpectrum", fields: { frequencyHz: [0.5, 1, 1.5] } },
  "/test/clock_state": { schema: "roseau.ClockState", fields: { device: "camera0", samples: "9000000000" } },
  "/test/gap": { schema: "roseau.Gap", fields: { missing: 3 } },
  "/test/drop": { schema: "roseau.Drop", fields: { stage: "recorder", count: "5000000000" } },
  "/test/health": { schema: "roseau.Health", fields: { recorder: "DEGRADED", recordingPhase: "POST_TRIGGER", recordingPart: 3, diskFreeS: 320 } },
  "/test/station_pose": {
    schema: "foxglove.PoseInFrame",
    fields: { pose: { position: { x: 0.25, y: -0.5, z: 0.75 }, orientation: { x: -0.5, y: 0.5, z: -0.5, w: 0.5 } } },
  },
  "/test/led_board_time": { schema: "roseau.LedBoardTime", fields: { event: "RISING_EDGE", tick: 4000000000 } },
  "/test/marker_positions": { schema: "foxglove.PosesInFrame", fields: { frameId: "world" } },
  "/test/modal_state": { schema: "roseau.ModalState", fields: { naturalFrequencyHz: [0.5, 1.5] } },
  "/test/log": { schema: "foxglove.Log", fields: { level: "ERROR", message: "no data" } },
};

async function checkEveryKind(reader) {
  const decoders = new Map();
  for (const channel of reader.channelsById.values()) {
    decoders.set(channel.id, decoderOf(reader.schemasById.get(channel.schemaId)));
  }
  const seen = new Set();
  const messages = await collect(reader.readMessages({ endTime: BEGIN_NS - 1n, validateCrcs: true }));
  for (const message of messages) {
    const channel = reader.channelsById.get(message.channelId);
    const expected = EXPECTED[channel.topic];
    assert.ok(expected, `unexpected topic ${channel.topic}`);
    assert.equal(reader.schemasById.get(channel.schemaId).name, expected.schema);
    assert.equal(`/test/${channel.metadata.get("roseau.kind")}`, channel.topic);
    const json = decoders.get(channel.id)(message.data);
    for (const [name, value] of Object.entries(expected.fields)) assert.deepEqual(json[name], value, `${channel.topic} ${name}`);
    assert.equal(json.timestamp, "1970-01-02T10:17:36.700000001Z", channel.topic);
    assert.equal(json.header.deviceTime, "-1.500s", channel.topic);
    assert.equal(message.sequence, 4000000000);
    assert.equal(message.publishTime, 123456700000001n);
    seen.add(channel.topic);
  }
  assert.deepEqual([...seen].sort(), Object.keys(EXPECTED).sort());
}

async function checkStreams(reader) {
  const winds = await collect(reader.readMessages({ topics: ["/sonic/wind"], validateCrcs: true }));
  assert.equal(winds.length, 200);
  const channel = [...reader.channelsById.values()].find((one) => one.topic === "/sonic/wind");
  const decode = decoderOf(reader.schemasById.get(channel.schemaId));
  winds.forEach((wind, i) => {
    assert.equal(wind.logTime, BEGIN_NS + BigInt(i) * 5_000_000n);
    assert.equal(decode(wind.data).uMps ?? 0, 0.5 * i);
    assert.equal(decode(wind.data).wMps, "NaN"); // not measured
  });
  const pictures = await collect(reader.readMessages({ topics: ["/camera1/image"], validateCrcs: true }));
  assert.equal(pictures.length, 30);
  for (const picture of pictures) assert.ok(picture.data.length > 640 * 480);
  const later = await collect(
    reader.readMessages({ topics: ["/sonic/wind"], startTime: BEGIN_NS + 500_000_000n, validateCrcs: true }),
  );
  assert.equal(later.length, 100);
}

async function checkHead(reader) {
  assert.equal(reader.header.profile, "x-roseau");
  const [session] = await collect(reader.readMetadata({ name: "roseau" }));
  assert.equal(session.metadata.get("program_version"), "0.0.0-test");
  assert.equal(session.metadata.get("operator"), "J. Müller");
  assert.equal(session.metadata.get("utc_minus_host_time_ns"), "7");
  const [counters] = await collect(reader.readMetadata({ name: "roseau.counters" }));
  assert.match(counters.metadata.get("/sonic/wind"), /received=200 recorded=200 dropped=0/);
  const attachments = await collect(reader.readAttachments({ validateCrcs: true }));
  assert.deepEqual(attachments.map((one) => [one.name, Buffer.from(one.data).toString()]), [
    ["config.toml", "[run]\n"],
    ["site.toml", "[site]\n"],
  ]);
  assert.equal(reader.statistics.messageCount, BigInt(Object.keys(EXPECTED).length + 230));
  assert.ok(reader.statistics.chunkCount >= 4);
}

function stream(bytes) {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  reader.append(bytes);
  let messages = 0;
  for (let record; (record = reader.nextRecord()); ) messages += record.type === "Message" ? 1 : 0;
  return { messages, done: reader.done() };
}

async function main() {
  const directory = mkdtempSync(join(tmpdir(), "roseau-mcap-reader-"));
  try {
    const path = join(directory, "session.mcap");
    execFileSync(join(process.env.ROSEAU_BIN ?? "build/bin", "write_session"), [path], { stdio: "inherit" });
    const bytes = new Uint8Array(readFileSync(path));
    const reader = await openIndexed(bytes);
    await checkHead(reader);
    await checkEveryKind(reader);
    await checkStreams(reader);
    assert.deepEqual(stream(bytes), { messages: Object.keys(EXPECTED).length + 230, done: true });

    // A file that was cut off: everything but its end.
    const cut = stream(bytes.subarray(0, Math.floor(bytes.length * 0.6)));
    assert.equal(cut.done, false);
    assert.ok(cut.messages > 50, `${cut.messages} messages of a cut file`);

    // The reader does check: one changed pixel is an error.
    const changed = bytes.slice();
    changed[Math.floor(bytes.length / 2)] ^= 1;
    const suspicious = await openIndexed(changed);
    await assert.rejects(collect(suspicious.readMessages({ validateCrcs: true })), /CRC/);
    console.log(`${reader.statistics.messageCount} messages of ${reader.channelsById.size} channels read and decoded`);
  } finally {
    rmSync(directory, { recursive: true, force: true });
  }
}

await main();
