// The top bar: is it recording, how long will the disk last, what time is it; record and mark.
import { act } from "../model/api.ts";
import type { Feed } from "../model/feed.ts";
import { bytes, clockDuration, fileName, roughDuration, timeOfDay } from "../model/format.ts";
import { DeviceState } from "../model/messages.ts";
import type { Session } from "../model/session.ts";
import { byId, setClass, setData, setHidden, setText } from "./dom.ts";
import type { Notices } from "./notices.ts";

const kConfirm_ms = 3000;
const kLowDisk_s = 15 * 60;
const kSmoothing = 0.1;

export class TopBar {
  private readonly recState = byId("rec-state");
  private readonly recWord = byId("rec-word");
  private readonly recTime = byId("rec-time");
  private readonly name = byId("session-name");
  private readonly mode = byId("mode");
  private readonly disk = byId("disk");
  private readonly clock = byId("clock");
  private readonly recordButton = byId("record") as HTMLButtonElement;
  private readonly recordLabel = byId("record-label");
  private readonly markButton = byId("mark") as HTMLButtonElement;
  private confirmUntil_ms = 0;
  private lastBytes: { count: number; at_s: number } | undefined;
  private rate_bytes_per_s = NaN;

  constructor(
    private readonly session: Session,
    private readonly feed: Feed,
    private readonly notices: Notices,
  ) {
    this.recordButton.addEventListener("click", () => void this.record());
    this.markButton.addEventListener("click", () => void this.mark());
  }

  get isRecording(): boolean {
    return (this.session.health?.recordingPath ?? "") !== "";
  }

  /** Starts at once; stopping takes a second press, for the storm does not come back. */
  async record(): Promise<void> {
    if (!this.isRecording) {
      this.notices.report(await act({ kind: "start_recording" }), "Recording starts");
      return;
    }
    if (performance.now() > this.confirmUntil_ms) {
      this.confirmUntil_ms = performance.now() + kConfirm_ms;
      return;
    }
    this.confirmUntil_ms = 0;
    this.notices.report(await act({ kind: "stop_recording" }), "Recording stops; the file is complete");
  }

  async mark(): Promise<void> {
    const time = this.clockText();
    this.notices.report(await act({ kind: "mark" }), time === "" ? "Marked" : `Marked ${time}`);
  }

  update(): void {
    const info = this.feed.info;
    setText(this.name, this.isRecording ? fileName(this.session.health!.recordingPath) : (info?.metadata["session"] ?? ""));
    const mode = info?.metadata["mode"] ?? "";
    setText(this.mode, mode === "live" ? "" : mode);
    setHidden(this.mode, mode === "" || mode === "live");
    setText(this.clock, this.clockText());
    this.updateRecording();
    this.updateDisk();
  }

  private updateRecording(): void {
    const health = this.session.health;
    const recording = this.isRecording;
    const state = health?.recorder ?? DeviceState.unknown;
    const trouble = state === DeviceState.degraded || state === DeviceState.failed;
    setData(this.recState, "state", trouble ? "bad" : recording ? "recording" : "idle");
    setText(this.recWord, state === DeviceState.failed ? "REC FAILED" : recording ? "REC" : "not recording");
    setText(this.recTime, recording ? clockDuration(health!.recordingS) : "");
    const confirming = performance.now() < this.confirmUntil_ms;
    setText(this.recordLabel, !recording ? "Record" : confirming ? "Press again to stop" : "Stop");
    setClass(this.recordButton, "sure", confirming);
    // What is replayed has happened: nothing can be recorded or marked in it.
    setHidden(this.markButton, this.session.isReplay);
    setHidden(this.recordButton, this.session.isReplay && !recording);
    setHidden(this.recState, this.session.isReplay && !recording);
  }

  private updateDisk(): void {
    const health = this.session.health;
    // Without a recording the daemon need not have looked at any disk.
    setHidden(this.disk, health === undefined || Number(health.diskFreeBytes) === 0);
    if (health === undefined) return;
    this.learnRate(Number(health.recordedBytes), health.recordingS);
    const free = Number(health.diskFreeBytes);
    const left_s = this.isRecording && this.rate_bytes_per_s > 0 ? free / this.rate_bytes_per_s : NaN;
    const low = left_s < kLowDisk_s;
    setText(this.disk, `${low ? "! " : ""}disk ${Number.isFinite(left_s) ? roughDuration(left_s) : bytes(free)}`);
    setClass(this.disk, "warn-text", low);
  }

  private learnRate(count: number, at_s: number): void {
    const last = this.lastBytes;
    if (last === undefined || at_s < last.at_s) {
      this.lastBytes = { count, at_s };
      this.rate_bytes_per_s = at_s > 5 ? count / at_s : NaN;
      return;
    }
    const step_s = at_s - last.at_s;
    if (step_s < 0.9) return;
    const rate = (count - last.count) / step_s;
    this.lastBytes = { count, at_s };
    if (!(this.rate_bytes_per_s > 0)) this.rate_bytes_per_s = rate;
    else this.rate_bytes_per_s += kSmoothing * (rate - this.rate_bytes_per_s);
  }

  private clockText(): string {
    const offset_ns = Number(this.feed.info?.metadata["civil_from_host_ns"] ?? 0);
    const time_ns = Number(this.session.state?.time_ns ?? 0);
    return offset_ns === 0 || time_ns === 0 ? "" : timeOfDay(time_ns + offset_ns);
  }
}
