import assert from "node:assert/strict";
import { test } from "node:test";
import { Session } from "../src/model/session.ts";
import { ActionKind, type StreamInfo } from "../src/model/messages.ts";

// JSON channels stand for protobuf ones: the session only sees what is decoded.
const kTopics: [string, string, string][] = [
  ["/sonic/wind", "roseau.Wind", "sonic"],
  ["/camera0/target/branch/displacement", "roseau.Displacement", "camera0"],
  ["/camera0/target/branch/wind", "roseau.WindEstimate", "camera0"],
  ["/wind/estimate", "roseau.WindEstimate", ""],
  ["/truth/wind", "roseau.Wind", "truth"],
  ["/roseau/operator", "roseau.OperatorAction", ""],
  ["/camera0/image", "foxglove.RawImage", "camera0"],
  ["/camera0/image/preview", "foxglove.CompressedImage", "camera0"],
  ["/display/state", "roseau.DisplayState", ""],
];

function session(): { session: Session; wanted: { subscribe: number[]; history: number[] }; send: (topic: string, time_s: number, message: object) => void } {
  const made = new Session();
  const channels = kTopics.map(([topic, schemaName], id) => ({ id, topic, schemaName, encoding: "json", schema: "", schemaEncoding: "jsonschema" }));
  const streams: StreamInfo[] = kTopics.map(([topic, , device], channel) => ({ channel, topic, kind: "", role: "raw", device, metadata: {} }));
  const wanted = made.addChannels(channels, streams);
  const send = (topic: string, time_s: number, message: object): void => {
    const id = kTopics.findIndex(([one]) => one === topic);
    const stamped = { timestamp: { seconds: Math.floor(time_s), nanos: Math.round((time_s % 1) * 1e9) }, ...message };
    made.receive(id, BigInt(Math.round(time_s * 1e9)), new TextEncoder().encode(JSON.stringify(stamped)));
  };
  return { session: made, wanted, send };
}

test("asks for what it shows: no raw pictures, no truth", () => {
  const { wanted, session: made } = session();
  assert.deepEqual(wanted.subscribe, [0, 1, 2, 3, 5, 7, 8]);
  assert.deepEqual(wanted.history, [0, 1, 2, 3]);
  assert.deepEqual(made.pictureChannels(), [7]);
  assert.equal(made.cameras.get("camera0")?.topic, "/camera0/image");
});

test("sorts messages to targets; the wind of all targets is nobody's", () => {
  const { session: made, send } = session();
  send("/camera0/target/branch/displacement", 10, { x: 1, y: 2, valid: true, unit: 1, health: 1 });
  send("/camera0/target/branch/wind", 9.75, { windMps: 4, windSdMps: 0.5, accepted: true });
  send("/wind/estimate", 9.75, { windMps: 5, windSdMps: 0.3, accepted: true });
  assert.deepEqual([...made.targets.keys()], ["/camera0/target/branch"]);
  const target = made.targets.get("/camera0/target/branch")!;
  assert.equal(target.estimate?.windMps, 4);
  assert.equal(made.fused.estimate?.windMps, 5);
  assert.equal(target.series.lastTime, 10);
  assert.equal(made.newest_s, 10);
});

test("what was not accepted or is lost leaves a hole", () => {
  const { session: made, send } = session();
  send("/camera0/target/branch/wind", 1, { windMps: 4, windSdMps: 0.5, accepted: false });
  send("/camera0/target/branch/displacement", 1, { x: 1, y: 2, valid: false, unit: 1, health: 0 });
  send("/sonic/wind", 1, { uMps: 1, vMps: 1, valid: false });
  const target = made.targets.get("/camera0/target/branch")!;
  assert.deepEqual(target.estimates.piece(0, 2).columns[0], [null]);
  assert.deepEqual(target.series.piece(0, 2).columns[0], [null]);
  assert.deepEqual(made.winds.get("/sonic/wind")!.series.piece(0, 2).columns[0], [null]);
});

test("removed targets are gone, and back when chosen again", () => {
  const { session: made, send } = session();
  send("/camera0/target/branch/displacement", 1, { x: 1, y: 2, valid: true, unit: 1, health: 1 });
  const target = made.targets.get("/camera0/target/branch")!;
  send("/roseau/operator", 2, { kind: ActionKind.removeTarget, text: "branch", camera: "camera1" });
  assert.equal(target.removed, false, "another camera's branch");
  send("/roseau/operator", 2.5, { kind: ActionKind.removeTarget, text: "branch", camera: "camera0" });
  assert.equal(target.removed, true);
  send("/roseau/operator", 3, { kind: ActionKind.addTarget, text: "branch" });
  assert.equal(target.removed, false);
});

test("a mark is shown once, however often it is told", () => {
  const { session: made, send } = session();
  for (let i = 0; i < 2; ++i) send("/roseau/operator", 5, { kind: ActionKind.mark, text: "gust" });
  assert.deepEqual(made.marks, [{ time_s: 5, text: "gust" }]);
});

function playerState(jumps: number): object {
  const player = { playing: true, ended: false, speed: 1, position_ns: "0", begin_ns: "0", end_ns: "1", jumps };
  return { time_ns: "0", clients: 1, images_dropped: 0, messages_dropped: 0, slow_clients: 0, pictures: [], player };
}

test("a replay that jumps clears what was shown; time that only looks back does not", () => {
  const { session: made, send } = session();
  let resets = 0;
  made.onReset = () => ++resets;
  send("/display/state", 0, playerState(3));
  send("/sonic/wind", 100, { uMps: 1, vMps: 1, valid: true });
  send("/sonic/wind", 50, { uMps: 2, vMps: 2, valid: true });
  assert.equal(made.winds.get("/sonic/wind")!.series.size, 1, "late, and left out");
  send("/camera0/target/branch/wind", 100, { windMps: 4, windSdMps: 0.5, accepted: true });
  send("/roseau/operator", 99, { kind: ActionKind.mark, text: "gust" });
  send("/display/state", 0, playerState(3));
  assert.equal(resets, 0);
  send("/display/state", 0, playerState(4));
  assert.equal(resets, 1);
  assert.equal(made.targets.get("/camera0/target/branch")!.estimate, undefined);
  assert.deepEqual(made.marks, []);
  send("/sonic/wind", 51, { uMps: 2, vMps: 2, valid: true });
  assert.equal(made.newest_s, 51);
  assert.equal(made.winds.get("/sonic/wind")!.series.size, 1);
  assert.equal(made.winds.get("/sonic/wind")!.series.lastTime, 51);
});

test("data just received from history is as old as it is", () => {
  const { session: made, send } = session();
  send("/sonic/wind", 10, { uMps: 1, vMps: 1, valid: true });
  send("/camera0/target/branch/displacement", 40, { x: 1, y: 2, valid: true, unit: 1, health: 1 });
  const wind = made.winds.get("/sonic/wind")!;
  assert.ok(Math.abs(made.age_s(wind.seen, wind.series) - 30) < 0.5);
});
