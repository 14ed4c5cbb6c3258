import assert from "node:assert/strict";
import { test } from "node:test";
import { lastOf } from "../src/model/last_of.ts";
import { DeviceState, RecordingPhase } from "../src/model/messages.ts";
import { positionOf } from "../src/model/position.ts";
import { recordingView } from "../src/model/recording.ts";
import { health } from "./samples.ts";

const running = { recordingPath: "/data/storm.mcap", recordingS: 751, recordingPhase: RecordingPhase.recording, recordingPart: 1, diskFreeS: 18_600 };

test("idle, the disk is told in bytes and a trigger's past in seconds", () => {
  const view = recordingView(health({ preTriggerS: 10 }));
  assert.equal(view.word, "not recording");
  assert.equal(view.disk, "38.0 GB free");
  assert.equal(view.more, "keeps the last 10 s for a trigger");
  assert.deepEqual(view.warnings, []);
  assert.equal(recordingView(undefined).word, "not recording");
});

test("recording says how long, which part and how long the disk lasts", () => {
  const view = recordingView(health({ ...running, recordingPart: 3 }));
  assert.deepEqual([view.word, view.time, view.more, view.disk], ["REC", "00:12:31", "part 3", "38.0 GB free = 5 h 10 min"]);
  assert.equal(view.isDiskLow, false);
  assert.equal(recordingView(health(running)).more, "", "a first part is all there is");
});

test("after a trigger it says what for and when it ends", () => {
  const view = recordingView(
    health({ ...running, recordingPhase: RecordingPhase.postTrigger, recordingCause: "trigger gust", recordingEndsS: 8 }),
  );
  assert.equal(view.more, "by trigger gust, ends in 8 s");
});

test("what is about to go wrong is said with what to do", () => {
  const copy = { directory: "/mnt/b", state: DeviceState.degraded, message: "the second disk is full: free space on it", verifiedBytes: 0n, behindBytes: 9n };
  const view = recordingView(health({ ...running, diskFreeS: 600, copy, onBattery: true, batteryPercent: 12 }));
  assert.equal(view.isDiskLow, true);
  assert.match(view.warnings[0]!, /full in 10 min.*Free space/);
  assert.match(view.warnings[1]!, /second copy: the second disk is full/);
  assert.match(view.warnings[2]!, /battery 12 % left.*Bring power/);
  assert.equal(view.power, "battery 12 %");
  assert.equal(recordingView(health({ batteryPercent: 90 })).power, "", "on the mains nobody asks");
  assert.match(recordingView(health({ preTriggerS: 4, preTriggerCutOff: 7n })).warnings[0]!, /only for the last 4 s/);
});

test("a second copy tells how far behind it is", () => {
  const copy = { directory: "/mnt/b", state: DeviceState.running, message: "", verifiedBytes: 5n, behindBytes: 12_000_000n };
  assert.equal(recordingView(health({ ...running, copy })).more, "second copy 12.0 MB behind");
  assert.equal(recordingView(health({ ...running, copy: { ...copy, behindBytes: 0n } })).more, "second copy verified");
});

test("a failed recorder is no recording", () => {
  const view = recordingView(health({ recorder: DeviceState.failed }));
  assert.deepEqual([view.level, view.word], ["bad", "REC FAILED"]);
});

test("a position is counted from the begin and stays in the recording", () => {
  const state = { playing: true, ended: false, speed: 1, begin_ns: "5000000000", end_ns: "65000000000", jumps: 0 };
  assert.deepEqual(positionOf({ ...state, position_ns: "17500000000" }), { begin_s: 5, length_s: 60, at_s: 12.5 });
  assert.equal(positionOf({ ...state, position_ns: "1" }).at_s, 0);
  assert.equal(positionOf({ ...state, position_ns: "99000000000" }).at_s, 60);
});

test("of wishes that come too fast only the last is asked", async () => {
  const asked: number[] = [];
  let release: (() => void) | undefined;
  const wish = lastOf(async (value: number) => {
    asked.push(value);
    await new Promise<void>((resolve) => (release = resolve));
  });
  for (const value of [1, 2, 3, 4]) wish(value);
  assert.deepEqual(asked, [1]);
  release!();
  await new Promise((resolve) => setTimeout(resolve, 0));
  assert.deepEqual(asked, [1, 4]);
  release!();
  await new Promise((resolve) => setTimeout(resolve, 0));
  wish(5);
  assert.deepEqual(asked, [1, 4, 5]);
});
