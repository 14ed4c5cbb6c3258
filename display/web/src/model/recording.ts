// What recording is doing, in the operator's words.
import { bytes, clockDuration, roughDuration } from "./format.ts";
import { DeviceState, RecordingPhase, type Health } from "./messages.ts";

const kLowDisk_s = 15 * 60;
const kLowBattery_percent = 20;

export interface RecordingView {
  isRecording: boolean;
  level: "idle" | "recording" | "bad";
  word: string; // "REC"
  time: string; // "00:12:31"
  more: string; // "part 3, by trigger gust, ends in 8 s"
  disk: string; // "38.0 GB free = 5 h 10 min"
  isDiskLow: boolean;
  power: string; // "battery 63 %"; empty on the mains
  isPowerLow: boolean;
  warnings: string[]; // with what to do
}

export function recordingView(health: Health | undefined): RecordingView {
  const recording = (health?.recordingPath ?? "") !== "";
  const state = health?.recorder ?? DeviceState.unknown;
  const trouble = state === DeviceState.degraded || state === DeviceState.failed;
  const view: RecordingView = {
    isRecording: recording,
    level: trouble ? "bad" : recording ? "recording" : "idle",
    word: state === DeviceState.failed ? "REC FAILED" : recording ? "REC" : "not recording",
    time: recording ? clockDuration(health!.recordingS) : "",
    more: "",
    disk: "",
    isDiskLow: false,
    power: "",
    isPowerLow: false,
    warnings: [],
  };
  if (health === undefined) return view;
  view.more = moreWords(health, recording);
  // Without a recording the daemon need not have looked at any disk.
  const free = Number(health.diskFreeBytes);
  if (free > 0) view.disk = `${bytes(free)} free${health.diskFreeS > 0 ? ` = ${roughDuration(health.diskFreeS)}` : ""}`;
  view.isDiskLow = recording && health.diskFreeS > 0 && health.diskFreeS < kLowDisk_s;
  if (health.onBattery && health.batteryPercent > 0) view.power = `battery ${Math.round(health.batteryPercent)} %`;
  view.isPowerLow = view.power !== "" && health.batteryPercent < kLowBattery_percent;
  view.warnings = warnings(health, view);
  return view;
}

function moreWords(health: Health, recording: boolean): string {
  const words: string[] = [];
  if (!recording) {
    if (health.preTriggerS > 0) words.push(`keeps the last ${roughDuration(health.preTriggerS)} for a trigger`);
    return words.join(", ");
  }
  if (health.recordingPart > 1) words.push(`part ${health.recordingPart}`);
  if (health.recordingCause.startsWith("trigger")) words.push(`by ${health.recordingCause}`);
  if (health.recordingPhase === RecordingPhase.postTrigger && health.recordingEndsS > 0) {
    words.push(`ends in ${roughDuration(health.recordingEndsS)}`);
  }
  const copy = health.copy;
  if (copy !== undefined && copy.directory !== "" && copy.message === "") {
    const behind = Number(copy.behindBytes);
    words.push(behind > 0 ? `second copy ${bytes(behind)} behind` : "second copy verified");
  }
  return words.join(", ");
}

function warnings(health: Health, view: RecordingView): string[] {
  const lines: string[] = [];
  if (view.isDiskLow) {
    lines.push(`disk: at this rate it is full in ${roughDuration(health.diskFreeS)}. Free space, or record fewer or smaller pictures`);
  }
  if (health.copy !== undefined && health.copy.message !== "") lines.push(`second copy: ${health.copy.message}`);
  if (view.isPowerLow) lines.push(`${view.power} left: recording stops cleanly before it is empty. Bring power`);
  if (!view.isRecording && Number(health.preTriggerCutOff) > 0) {
    lines.push(`trigger: there is memory only for the last ${roughDuration(health.preTriggerS)}. Give recording more of it in the configuration`);
  }
  return lines;
}
