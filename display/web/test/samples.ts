// Messages for the tests, with every field set.
import { DeviceState, RecordingPhase, type Health } from "../src/model/messages.ts";

/** All is well and nothing is recorded, but for what is changed. */
export function health(change: Partial<Health> = {}): Health {
  return {
    streams: [],
    devices: [],
    recorder: DeviceState.running,
    recorderMessage: "",
    recordingPath: "",
    recordingS: 0,
    recordedBytes: 0n,
    diskFreeBytes: 38_000_000_000n,
    recordingPhase: RecordingPhase.idle,
    recordingCause: "",
    recordingEndsS: 0,
    recordingPart: 0,
    sessionBytes: 0n,
    writeRateBytesPerS: 0,
    diskFreeS: 0,
    preTriggerS: 0,
    preTriggerBytes: 0n,
    preTriggerCutOff: 0n,
    batteryPercent: 0,
    onBattery: false,
    ...change,
  };
}
