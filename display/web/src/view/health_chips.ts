// Health: one chip per device, a word only when something is wrong, details on a press.
import { fixed, rate, roughDuration, smallTime } from "../model/format.ts";
import { DeviceState, type DeviceHealth, type Health, type StreamHealth } from "../model/messages.ts";
import { recordingView } from "../model/recording.ts";
import type { Session } from "../model/session.ts";
import { byId, h, setClass, setData, setHidden, setText } from "./dom.ts";

export type Level = "ok" | "warn" | "bad" | "plain";

export interface DeviceView {
  name: string;
  level: Level;
  rate: string;
  words: string; // next to the name: counts of what was lost; empty when all is well
  message: string; // what is wrong and what to do; empty when all is well
  streams: StreamHealth[];
}

const kSign: Record<Level, string> = { ok: "✓", warn: "!", bad: "✕", plain: "…" };
const kHealthStale_s = 3;

const kLevel: Record<DeviceState, Level> = {
  [DeviceState.unknown]: "plain",
  [DeviceState.starting]: "plain",
  [DeviceState.running]: "ok",
  [DeviceState.degraded]: "warn",
  [DeviceState.reopening]: "bad",
  [DeviceState.failed]: "bad",
  [DeviceState.finished]: "plain",
};
const kStateWord: Record<DeviceState, string> = {
  [DeviceState.unknown]: "",
  [DeviceState.starting]: "starting",
  [DeviceState.running]: "",
  [DeviceState.degraded]: "",
  [DeviceState.reopening]: "reopening",
  [DeviceState.failed]: "failed",
  [DeviceState.finished]: "ended",
};

/** The stream a device's rate is told by: pictures or decoded records, before raw bytes. */
function mainStream(streams: StreamHealth[], session: Session): StreamHealth | undefined {
  const rank = (stream: StreamHealth): number => {
    const kind = session.streams.get(stream.topic)?.kind;
    return kind === "frame" ? 0 : kind === "wind" ? 1 : kind === "displacement" ? 2 : kind === "raw_bytes" ? 3 : 4;
  };
  return [...streams].sort((a, b) => rank(a) - rank(b))[0];
}

function count(value: number, one: string, many: string): string {
  return value === 0 ? "" : `${value} ${value === 1 ? one : many}`;
}

function lossWords(streams: StreamHealth[]): string {
  const sum = (pick: (stream: StreamHealth) => bigint): number => streams.reduce((all, one) => all + Number(pick(one)), 0);
  return [
    count(sum((s) => s.gaps), "gap", "gaps"),
    count(sum((s) => s.dropped), "drop", "drops"),
    count(sum((s) => s.bad), "bad", "bad"),
  ]
    .filter((word) => word !== "")
    .join(", ");
}

export function deviceViews(health: Health, session: Session): DeviceView[] {
  const ofDevice = (name: string): StreamHealth[] =>
    health.streams.filter((stream) => session.streams.get(stream.topic)?.device === name);
  // What only a simulation knows is no device of the operator's.
  const shown = health.devices.filter((device) => !ofDevice(device.name).some((stream) => stream.topic.startsWith("/truth/")));
  return shown.map((device: DeviceHealth) => {
    const streams = ofDevice(device.name);
    const main = mainStream(streams, session);
    const losses = lossWords(streams);
    const level = kLevel[device.state];
    return {
      name: device.name,
      level: level === "ok" && losses !== "" ? "warn" : level,
      rate: main === undefined ? "" : rate(main.rateHz),
      words: [kStateWord[device.state], losses].filter((word) => word !== "").join(", "),
      message: device.message,
      streams,
    };
  });
}

interface Chip {
  button: HTMLButtonElement;
  sign: HTMLElement;
  rate: HTMLElement;
  words: HTMLElement;
}

export class HealthChips {
  private readonly place = byId("chips");
  private readonly alerts = byId("alerts");
  private readonly details = byId("details");
  private readonly chips = new Map<string, Chip>();
  private opened: string | undefined;

  constructor(private readonly session: Session) {}

  update(connected: boolean): void {
    const health = this.session.health;
    if (health === undefined) return;
    const views = deviceViews(health, this.session);
    for (const view of views) this.updateChip(this.chipOf(view.name), view);
    const stale = connected && this.session.healthSeen.age_s > kHealthStale_s && this.session.state?.player?.playing !== false;
    this.updateAlerts(health, views, stale);
    for (const [name, chip] of this.chips) {
      if (views.some((view) => view.name === name)) continue;
      chip.button.remove();
      this.chips.delete(name);
    }
    const opened = views.find((view) => view.name === this.opened);
    setHidden(this.details, opened === undefined);
    if (opened !== undefined) this.showDetails(opened);
  }

  close(): void {
    this.opened = undefined;
    setHidden(this.details, true);
  }

  private chipOf(name: string): Chip {
    const known = this.chips.get(name);
    if (known !== undefined) return known;
    const chip: Chip = {
      button: h("button", "chip"),
      sign: h("span", "sign"),
      rate: h("span", "num"),
      words: h("span", "chip-words"),
    };
    chip.button.type = "button";
    chip.button.append(chip.sign, h("span", "chip-name", name), chip.rate, chip.words);
    chip.button.addEventListener("click", () => {
      this.opened = this.opened === name ? undefined : name;
      this.update(true);
    });
    this.place.append(chip.button);
    this.chips.set(name, chip);
    return chip;
  }

  private updateChip(chip: Chip, view: DeviceView): void {
    setData(chip.button, "level", view.level);
    setText(chip.sign, kSign[view.level]);
    setText(chip.rate, view.rate);
    setText(chip.words, view.words);
    setHidden(chip.words, view.words === "");
    chip.button.setAttribute("aria-expanded", String(this.opened === view.name));
  }

  private updateAlerts(health: Health, views: DeviceView[], stale: boolean): void {
    const lines: [Level, string][] = [];
    if (stale) lines.push(["bad", `the daemon answers, but has told nothing of its state for ${roughDuration(this.session.healthSeen.age_s)}`]);
    if (health.recorderMessage !== "") {
      lines.push([health.recorder === DeviceState.running ? "warn" : kLevel[health.recorder], `recorder: ${health.recorderMessage}`]);
    }
    for (const words of recordingView(health).warnings) lines.push(["warn", words]);
    for (const view of views) {
      if (view.message !== "" && view.level !== "ok") lines.push([view.level, `${view.name}: ${view.message}`]);
    }
    const key = lines.map((line) => line.join(" ")).join("\n");
    if (this.alerts.dataset["key"] === key) return;
    this.alerts.dataset["key"] = key;
    this.alerts.replaceChildren(
      ...lines.map(([level, words]) => h("p", `alert ${level}`, h("span", "sign", kSign[level]), h("span", "", words))),
    );
    setClass(this.alerts, "empty", lines.length === 0);
  }

  private showDetails(view: DeviceView): void {
    const head = ["stream", "rate", "last", "received", "recorded", "gaps", "dropped", "bad", "late"];
    const cells = view.streams.map((stream) => [
      stream.topic,
      rate(stream.rateHz),
      stream.ageS < 1 ? "now" : `${roughDuration(stream.ageS)} ago`,
      ...[stream.received, stream.recorded, stream.gaps, stream.dropped, stream.bad, stream.late].map(String),
    ]);
    const key = JSON.stringify([view.name, view.message, cells, this.clockWords(view.name)]);
    if (this.details.dataset["key"] === key) return;
    this.details.dataset["key"] = key;
    const close = h("button", "icon-button", "✕");
    close.type = "button";
    close.setAttribute("aria-label", "close the details");
    close.addEventListener("click", () => this.close());
    const row = (tag: "th" | "td", texts: string[]): HTMLElement => h("tr", "", ...texts.map((text) => h(tag, "", text)));
    this.details.replaceChildren(
      h("div", "tile-head", h("h2", "", view.name), h("span", "muted", this.clockWords(view.name)), h("span", "grow"), close),
      h("div", "table-frame", h("table", "", h("thead", "", row("th", head)), h("tbody", "", ...cells.map((c) => row("td", c))))),
    );
  }

  private clockWords(device: string): string {
    const clock = this.session.clocks.get(device);
    if (clock === undefined) return "clock: the host's";
    const drift = `${fixed(clock.frequencyOffsetPpm, 1)} ppm`;
    return `clock known to ${smallTime(clock.offsetSdS)}, off by ${drift}, jitter ${smallTime(clock.jitterS)}`;
  }
}
