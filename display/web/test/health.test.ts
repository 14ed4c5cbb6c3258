import assert from "node:assert/strict";
import { test } from "node:test";
import { DeviceState, type StreamHealth } from "../src/model/messages.ts";
import { motionOf } from "../src/model/motion.ts";
import { Session } from "../src/model/session.ts";
import { targetKey, targetName } from "../src/model/target.ts";
import { deviceViews } from "../src/view/health_chips.ts";
import { health } from "./samples.ts";

function stream(topic: string, rateHz: number, counters: Partial<StreamHealth> = {}): StreamHealth {
  const none = { received: 0n, recorded: 0n, dropped: 0n, gaps: 0n, bad: 0n, late: 0n };
  return { topic, rateHz, ageS: 0, ...none, ...counters };
}

function sessionWith(topics: [string, string, string][]): Session {
  const session = new Session();
  for (const [topic, kind, device] of topics) {
    session.streams.set(topic, { channel: 1, topic, kind, role: "raw", device, metadata: {} });
  }
  return session;
}

test("a chip tells a device's rate by its records, not by its bytes", () => {
  const session = sessionWith([
    ["/sonic/raw", "raw_bytes", "sonic"],
    ["/sonic/wind", "wind", "sonic"],
  ]);
  const [view] = deviceViews(
    health({
      streams: [stream("/sonic/raw", 47), stream("/sonic/wind", 20)],
      devices: [{ name: "sonic", state: DeviceState.running, message: "" }],
    }),
    session,
  );
  assert.equal(view?.rate, "20.0/s");
  assert.equal(view?.level, "ok");
  assert.equal(view?.words, "");
});

test("losses are told in words and turn the chip amber", () => {
  const session = sessionWith([["/camera0/image", "frame", "camera0"]]);
  const [view] = deviceViews(
    health({
      streams: [stream("/camera0/image", 30, { gaps: 1n, dropped: 12n })],
      devices: [{ name: "camera0", state: DeviceState.running, message: "" }],
    }),
    session,
  );
  assert.equal(view?.level, "warn");
  assert.equal(view?.words, "1 gap, 12 drops");
});

test("a device that is being reopened is bad whatever its counters say", () => {
  const [view] = deviceViews(
    health({ devices: [{ name: "tracker", state: DeviceState.reopening, message: "check its cable" }] }),
    new Session(),
  );
  assert.equal(view?.level, "bad");
  assert.equal(view?.message, "check its cable");
  assert.equal(view?.words, "reopening");
});

test("a simulation's truth is no device", () => {
  const session = sessionWith([["/truth/wind", "wind", "truth"]]);
  const devices = [{ name: "truth", state: DeviceState.running, message: "" }];
  assert.deepEqual(deviceViews(health({ streams: [stream("/truth/wind", 20)], devices }), session), []);
});

test("targets are known by their topics", () => {
  assert.equal(targetKey("/camera0/target/branch/displacement"), "/camera0/target/branch");
  assert.equal(targetKey("/camera0/target/branch/wind"), "/camera0/target/branch");
  assert.equal(targetKey("/displacement/tree7"), "/displacement/tree7");
  assert.equal(targetKey("/displacement/tree7/wind"), "/displacement/tree7");
  assert.equal(targetName("/camera0/target/branch"), "branch");
});

test("motion is read from annotations", () => {
  const metadata = (entries: Record<string, string>): { key: string; value: string }[] =>
    Object.entries(entries).map(([key, value]) => ({ key, value }));
  const corners = [
    { x: 10, y: 20 },
    { x: 40, y: 20 },
    { x: 40, y: 60 },
    { x: 10, y: 60 },
  ];
  const motion = motionOf({
    points: [
      { type: 2, points: corners, metadata: metadata({ name: "branch", health: "0.5", valid: "false" }) },
      { type: 4, points: [{ x: 1, y: 2 }, { x: 3, y: 4 }], metadata: metadata({ target: "background", good: "true" }) },
      { type: 2, points: corners, metadata: [] }, // somebody else's drawing
    ],
  });
  assert.deepEqual(motion.targets, [{ name: "branch", region: { x: 10, y: 20, width: 30, height: 40 }, health: 0.5, valid: false }]);
  assert.equal(motion.vectors.length, 1);
  assert.equal(motion.vectors[0]!.background, true);
  assert.deepEqual([...motion.vectors[0]!.points], [3, 4, 1, 2]);
});
