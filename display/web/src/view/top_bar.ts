// The top bar: is it recording, how long will the disk last, what time is it; record, trigger and mark.
import { act } from "../model/api.ts";
import type { Feed } from "../model/feed.ts";
import { fileName, roughDuration, timeOfDay } from "../model/format.ts";
import { recordingView } from "../model/recording.ts";
import type { Session } from "../model/session.ts";
import { byId, setClass, setData, setHidden, setText } from "./dom.ts";
import type { Notices } from "./notices.ts";

const kConfirm_ms = 3000;

export class TopBar {
  private readonly recState = byId("rec-state");
  private readonly recWord = byId("rec-word");
  private readonly recTime = byId("rec-time");
  private readonly recMore = byId("rec-more");
  private readonly name = byId("session-name");
  private readonly mode = byId("mode");
  private readonly disk = byId("disk");
  private readonly clock = byId("clock");
  private readonly recordButton = byId("record") as HTMLButtonElement;
  private readonly recordLabel = byId("record-label");
  private readonly markButton = byId("mark") as HTMLButtonElement;
  private readonly triggerButton = byId("trigger") as HTMLButtonElement;
  private confirmUntil_ms = 0;

  constructor(
    private readonly session: Session,
    private readonly feed: Feed,
    private readonly notices: Notices,
  ) {
    this.recordButton.addEventListener("click", () => void this.record());
    this.markButton.addEventListener("click", () => void this.mark());
    this.triggerButton.addEventListener("click", () => void this.trigger());
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

  /** Something happens now: what came before it is kept too, as configured. */
  async trigger(): Promise<void> {
    const past_s = this.isRecording ? 0 : (this.session.health?.preTriggerS ?? 0);
    const done = past_s > 0 ? `Triggered: recording from ${roughDuration(past_s)} ago` : "Triggered";
    this.notices.report(await act({ kind: "trigger" }), done);
  }

  update(): void {
    const info = this.feed.info;
    setText(this.name, this.isRecording ? fileName(this.session.health!.recordingPath) : (info?.metadata["session"] ?? ""));
    const mode = info?.metadata["mode"] ?? "";
    setText(this.mode, mode === "live" ? "" : mode);
    setHidden(this.mode, mode === "" || mode === "live");
    setText(this.clock, this.clockText());
    this.updateRecording();
  }

  private updateRecording(): void {
    const view = recordingView(this.session.health);
    setData(this.recState, "state", view.level);
    setText(this.recWord, view.word);
    setText(this.recTime, view.time);
    setText(this.recMore, view.more);
    const confirming = performance.now() < this.confirmUntil_ms;
    setText(this.recordLabel, !view.isRecording ? "Record" : confirming ? "Press again to stop" : "Stop");
    setClass(this.recordButton, "sure", confirming);
    // What is replayed has happened: nothing can be recorded or marked in it.
    const isHistory = this.session.isReplay;
    setHidden(this.markButton, isHistory);
    setHidden(this.triggerButton, isHistory);
    for (const element of [this.recordButton, byId("rec")]) setHidden(element, isHistory && !view.isRecording);
    const disk = [view.disk, view.power].filter((words) => words !== "").join(", ");
    const isLow = view.isDiskLow || view.isPowerLow;
    setText(this.disk, isLow ? `! ${disk}` : disk);
    setClass(this.disk, "warn-text", isLow);
  }

  private clockText(): string {
    const offset_ns = Number(this.feed.info?.metadata["civil_from_host_ns"] ?? 0);
    const time_ns = Number(this.session.state?.time_ns ?? 0);
    return offset_ns === 0 || time_ns === 0 ? "" : timeOfDay(time_ns + offset_ns);
  }
}
