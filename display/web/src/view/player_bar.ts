// Replay controls: only there while a recording is played.
import { fetchMarks, play, type PlayerCommand, type RecordedMark } from "../model/api.ts";
import type { Feed } from "../model/feed.ts";
import { clockDuration, timeOfDay } from "../model/format.ts";
import { lastOf } from "../model/last_of.ts";
import type { PlayerState } from "../model/messages.ts";
import { positionOf, type Position } from "../model/position.ts";
import type { Session } from "../model/session.ts";
import { byId, h, setClass, setHidden, setText } from "./dom.ts";
import type { Notices } from "./notices.ts";

const kSpeeds: [string, number | null][] = [
  ["½ ×", 0.5],
  ["1 ×", 1],
  ["2 ×", 2],
  ["4 ×", 4],
  ["max", null],
];
const kStep_s = 5;
// After a seek the slider stays where it was put until the daemon, which tells four times a second, has followed.
const kHold_ms = 600;

export class PlayerBar {
  private readonly bar = byId("player");
  private readonly button = byId("play");
  private readonly label = byId("play-label");
  private readonly clock = byId("player-clock");
  private readonly position = byId("player-position");
  private readonly slider = byId("seek") as HTMLInputElement;
  private readonly marks = byId("seek-marks");
  private readonly speeds = new Map<number | null, HTMLButtonElement>();
  private readonly seek = lastOf((time_s: number) => this.ask({ command: "seek", time_s }));
  private heldUntil_ms = 0;
  private marksOf = "";

  constructor(
    private readonly session: Session,
    private readonly feed: Feed,
    private readonly notices: Notices,
  ) {
    this.button.addEventListener("click", () => this.toggle());
    byId("step-back").addEventListener("click", () => this.step(-1));
    byId("step-on").addEventListener("click", () => this.step(+1));
    this.slider.addEventListener("input", () => this.seekTo(Number(this.slider.value)));
    for (const [label, speed] of kSpeeds) {
      const button = h("button", "", label);
      button.type = "button";
      button.addEventListener("click", () => void this.ask({ command: "speed", speed }));
      byId("speeds").append(button);
      this.speeds.set(speed, button);
    }
  }

  toggle(): void {
    const state = this.session.state?.player;
    if (state == null) return;
    void this.ask({ command: state.playing && !state.ended ? "pause" : "play" });
  }

  /** -1: a little back, +1: a little on. */
  step(direction: number): void {
    const state = this.session.state?.player;
    if (state == null) return;
    const { at_s, length_s } = positionOf(state);
    const from_s = this.isHeld ? Number(this.slider.value) : at_s;
    this.seekTo(Math.min(length_s, Math.max(0, from_s + direction * kStep_s)));
  }

  update(): void {
    const state = this.session.state?.player ?? undefined;
    setHidden(this.bar, state === undefined);
    if (state !== undefined) this.show(state);
  }

  private get isHeld(): boolean {
    return performance.now() < this.heldUntil_ms;
  }

  private seekTo(time_s: number): void {
    this.heldUntil_ms = performance.now() + kHold_ms;
    this.slider.value = String(time_s);
    this.update();
    this.seek(time_s);
  }

  private show(state: PlayerState): void {
    const told = positionOf(state);
    const place = this.isHeld ? { ...told, at_s: Number(this.slider.value) } : told;
    setText(this.label, state.playing && !state.ended ? "Pause" : "Play");
    const position = `${clockDuration(place.at_s)} of ${clockDuration(place.length_s)}`;
    const clock = this.timeOfDay(place);
    setText(this.position, state.ended && !this.isHeld ? `${position}, the end` : position);
    setText(this.clock, clock);
    this.showSlider(place, clock === "" ? position : `${clock}, ${position}`);
    for (const [speed, button] of this.speeds) {
      setClass(button, "on", speed === state.speed);
      button.setAttribute("aria-pressed", String(speed === state.speed));
    }
    void this.learnMarks(state);
  }

  private showSlider(place: Position, words: string): void {
    const length = String(place.length_s);
    if (this.slider.max !== length) this.slider.max = length;
    if (!this.isHeld) this.slider.value = String(place.at_s);
    if (this.slider.getAttribute("aria-valuetext") !== words) this.slider.setAttribute("aria-valuetext", words);
    this.slider.style.setProperty("--at", String(place.length_s > 0 ? place.at_s / place.length_s : 0));
  }

  private timeOfDay(place: Position): string {
    const offset_ns = Number(this.feed.info?.metadata["civil_from_host_ns"] ?? 0);
    return offset_ns === 0 ? "" : timeOfDay((place.begin_s + place.at_s) * 1e9 + offset_ns);
  }

  /** What the operator marked when this was recorded stands on the slider from the start. */
  private async learnMarks(state: PlayerState): Promise<void> {
    const key = `${this.feed.info?.sessionId ?? ""} ${state.begin_ns}`;
    if (this.marksOf === key) return;
    this.marksOf = key;
    let marks: RecordedMark[] = [];
    try {
      marks = await fetchMarks();
    } catch {
      this.marksOf = ""; // lost in between: asked again
    }
    const { begin_s, length_s } = positionOf(state);
    this.marks.replaceChildren(
      ...marks.map(({ time_ns, text }) => {
        const mark = h("span", "seek-mark");
        mark.style.setProperty("--at", String(length_s > 0 ? (Number(time_ns) * 1e-9 - begin_s) / length_s : 0));
        mark.title = text;
        return mark;
      }),
    );
  }

  private async ask(command: PlayerCommand): Promise<void> {
    const error = await play(command);
    if (error !== undefined) this.notices.say(error, "bad");
  }
}
