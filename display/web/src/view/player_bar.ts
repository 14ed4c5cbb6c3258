// Replay controls: only there while a recording is played.
import { play } from "../model/api.ts";
import { clockDuration } from "../model/format.ts";
import type { PlayerState } from "../model/messages.ts";
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

export class PlayerBar {
  private readonly bar = byId("player");
  private readonly button = byId("play");
  private readonly label = byId("play-label");
  private readonly position = byId("player-position");
  private readonly progress = byId("player-progress") as HTMLProgressElement;
  private readonly speeds = new Map<number | null, HTMLButtonElement>();

  constructor(
    private readonly session: Session,
    private readonly notices: Notices,
  ) {
    this.button.addEventListener("click", () => this.toggle());
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
    void this.ask({ command: state.playing ? "pause" : "play" });
  }

  update(): void {
    const state = this.session.state?.player ?? undefined;
    setHidden(this.bar, state === undefined);
    if (state !== undefined) this.show(state);
  }

  private show(state: PlayerState): void {
    const begin_s = Number(state.begin_ns) * 1e-9;
    const length_s = Number(state.end_ns) * 1e-9 - begin_s;
    const at_s = Math.min(length_s, Math.max(0, Number(state.position_ns) * 1e-9 - begin_s));
    setText(this.label, state.ended ? "Ended" : state.playing ? "Pause" : "Play");
    setText(this.position, `${clockDuration(at_s)} of ${clockDuration(length_s)}`);
    this.progress.value = length_s > 0 ? at_s / length_s : 0;
    for (const [speed, button] of this.speeds) {
      setClass(button, "on", speed === state.speed);
      button.setAttribute("aria-pressed", String(speed === state.speed));
    }
  }

  private async ask(command: Parameters<typeof play>[0]): Promise<void> {
    const error = await play(command);
    if (error !== undefined) this.notices.say(error, "bad");
  }
}
