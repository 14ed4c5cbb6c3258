// Session: everything the page knows, filled by messages, read by the views. No DOM here.
import { decoderFor, type Decode } from "../protocol/decoder.ts";
import type { Channel } from "../protocol/codec.ts";
import {
  ActionKind,
  seconds,
  type ClockState,
  type CompressedImage,
  type Displacement,
  type DisplayState,
  type ForceSpectrum,
  type Health,
  type Identification,
  type ImageAnnotations,
  type LogEntry,
  type OperatorAction,
  type StreamInfo,
  type Wind,
  type WindCalibration,
  type WindEstimate,
} from "./messages.ts";
import { motionOf, type Motion } from "./motion.ts";
import type { TimeSeries } from "./series.ts";
import { Freshness, Target, targetKey, targetName, WindStream } from "./target.ts";
import { horizontalWind, mountingOf } from "./wind.ts";

export interface Camera {
  device: string;
  topic: string; // of the frames
  preview: number; // channel
  width_px: number; // of the frames; 0 until known
  height_px: number;
  motion: Motion | undefined;
  motionSeen: Freshness;
  pictureSeen: Freshness;
  onPicture: ((image: CompressedImage) => void) | undefined;
}

export interface Mark {
  time_s: number;
  text: string;
}

interface Subscribed {
  channel: Channel;
  decode: Decode;
}

const kPreview = "/preview";
const kTruth = "/truth/"; // what only a simulation knows is not for the operator
const kFused = "/wind/estimate"; // one wind from all targets

/** Channels the page reads, by schema; of the others it only shows how they are. */
const kRead = new Set([
  "roseau.Wind",
  "roseau.Displacement",
  "roseau.Identification",
  "roseau.WindEstimate",
  "roseau.WindCalibration",
  "roseau.ForceSpectrum",
  "roseau.ClockState",
  "roseau.Health",
  "roseau.OperatorAction",
  "roseau.DisplayState",
  "foxglove.Log",
  "foxglove.CompressedImage",
  "foxglove.ImageAnnotations",
]);

/** Channels whose past the server keeps. */
const kWithHistory = new Set(["roseau.Wind", "roseau.Displacement", "roseau.WindEstimate"]);

export class Session {
  readonly cameras = new Map<string, Camera>(); // by device
  readonly targets = new Map<string, Target>(); // by key
  /** One wind from all targets that can be compared; a target in form only. */
  readonly fused = new Target("/wind", "all targets", "");
  readonly winds = new Map<string, WindStream>(); // by topic
  readonly clocks = new Map<string, ClockState>(); // by device
  readonly streams = new Map<string, StreamInfo>(); // by topic
  readonly marks: Mark[] = [];
  readonly log: LogEntry[] = [];
  readonly healthSeen = new Freshness();
  health: Health | undefined;
  state: DisplayState | undefined;
  /** How often everything was forgotten. */
  resets = 0;
  /** Newest log time seen, s. */
  newest_s = -Infinity;
  onReset: (() => void) | undefined;

  private readonly channels = new Map<number, Subscribed>();

  /** Takes in what streams are, and the channels; returns those to subscribe to, and those whose past to ask for. */
  addChannels(channels: Channel[], streams: StreamInfo[]): { subscribe: number[]; history: number[] } {
    for (const stream of streams) this.streams.set(stream.topic, stream);
    const wanted: { subscribe: number[]; history: number[] } = { subscribe: [], history: [] };
    for (const channel of channels) {
      if (!kRead.has(channel.schemaName) || channel.topic.startsWith(kTruth)) continue;
      const decode = decoderFor(channel);
      if (decode === undefined) continue;
      this.channels.set(channel.id, { channel, decode });
      this.meet(channel);
      wanted.subscribe.push(channel.id);
      if (kWithHistory.has(channel.schemaName)) wanted.history.push(channel.id);
    }
    return wanted;
  }

  /** Channels that only pictures are made from: not needed while nobody looks. */
  pictureChannels(): number[] {
    const drawn = ["foxglove.CompressedImage", "foxglove.ImageAnnotations"];
    return [...this.channels].filter(([, one]) => drawn.includes(one.channel.schemaName)).map(([id]) => id);
  }

  /** Another run of the daemon, or a replay that went to another place: what was known no longer holds. */
  reset(): void {
    ++this.resets;
    for (const camera of this.cameras.values()) camera.motion = undefined;
    for (const target of this.targets.values()) target.clear();
    this.fused.clear();
    for (const wind of this.winds.values()) wind.clear();
    this.marks.length = 0;
    this.newest_s = -Infinity;
    this.onReset?.();
  }

  forgetRun(): void {
    this.reset();
    for (const map of [this.cameras, this.targets, this.winds, this.clocks, this.streams, this.channels]) map.clear();
    this.log.length = 0;
    this.health = undefined;
    this.state = undefined;
  }

  receive(channelId: number, logTime_ns: bigint, payload: Uint8Array): void {
    const known = this.channels.get(channelId);
    if (known === undefined) return;
    const logTime_s = Number(logTime_ns) * 1e-9;
    const { schemaName, topic } = known.channel;
    if (kWithHistory.has(schemaName)) {
      this.newest_s = Math.max(this.newest_s, logTime_s);
    }
    this.take(schemaName, topic, known.decode(payload));
  }

  get isReplay(): boolean {
    return this.state?.player != null;
  }

  /**
   * How old the newest of a series is: in real time since it came, or in the session's own time, whichever is more. A page
   * just opened has received the past a moment ago.
   */
  age_s(seen: Freshness, series: TimeSeries): number {
    return Math.max(seen.age_s, this.newest_s - series.lastTime);
  }

  /** The wind that a target's estimate is compared with, else the first measured one. */
  measuredWind(target: Target | undefined): WindStream | undefined {
    return this.winds.get(target?.calibration?.reference ?? "") ?? [...this.winds.values()][0];
  }

  private device(topic: string): string {
    return this.streams.get(topic)?.device || (topic.split("/")[1] ?? "");
  }

  private meet(channel: Channel): void {
    const topic = channel.topic;
    if (channel.schemaName === "foxglove.CompressedImage" && topic.endsWith(kPreview)) {
      const frames = topic.slice(0, -kPreview.length);
      const device = this.device(frames);
      if (this.cameras.has(device)) return;
      this.cameras.set(device, {
        device,
        topic: frames,
        preview: channel.id,
        width_px: 0,
        height_px: 0,
        motion: undefined,
        motionSeen: new Freshness(),
        pictureSeen: new Freshness(),
        onPicture: undefined,
      });
    }
    if (channel.schemaName === "roseau.Displacement") this.target(topic);
    if (channel.schemaName === "roseau.Wind" && !this.winds.has(topic)) {
      const mounting = mountingOf(this.streams.get(topic)?.metadata ?? {});
      this.winds.set(topic, new WindStream(topic, this.device(topic), mounting));
    }
  }

  private target(topic: string): Target {
    const key = targetKey(topic);
    let target = this.targets.get(key);
    if (target === undefined) {
      target = new Target(key, targetName(key), this.device(topic));
      this.targets.set(key, target);
    }
    return target;
  }

  private take(schemaName: string, topic: string, message: unknown): void {
    switch (schemaName) {
      case "roseau.Wind":
        return this.takeWind(topic, message as Wind);
      case "roseau.Displacement":
        return this.takeDisplacement(this.target(topic), message as Displacement);
      case "roseau.WindEstimate":
        return this.takeEstimate(topic === kFused ? this.fused : this.target(topic), message as WindEstimate);
      case "roseau.Identification":
        this.target(topic).identification = message as Identification;
        return;
      case "roseau.WindCalibration":
        this.target(topic).calibration = message as WindCalibration;
        return;
      case "roseau.ForceSpectrum":
        this.target(topic).spectrum = message as ForceSpectrum;
        return;
      case "roseau.ClockState":
        this.clocks.set((message as ClockState).device, message as ClockState);
        return;
      case "roseau.Health":
        this.health = message as Health;
        this.healthSeen.see();
        return;
      case "roseau.OperatorAction":
        return this.takeAction(message as OperatorAction);
      case "roseau.DisplayState":
        return this.takeState(message as DisplayState);
      case "foxglove.Log":
        this.log.push(message as LogEntry);
        if (this.log.length > 100) this.log.shift();
        return;
      case "foxglove.ImageAnnotations":
        return this.takeMotion(this.cameras.get(this.device(topic)), message as ImageAnnotations);
      case "foxglove.CompressedImage":
        return this.takePicture(this.cameras.get(this.device(topic.slice(0, -kPreview.length))), message as CompressedImage);
    }
  }

  private takeWind(topic: string, message: Wind): void {
    const wind = this.winds.get(topic);
    if (wind === undefined) return;
    const time_s = seconds(message.timestamp);
    const usable = message.valid && Number.isFinite(message.uMps) && Number.isFinite(message.vMps);
    if (!usable) {
      wind.series.push(time_s, NaN, NaN);
      return;
    }
    const value = horizontalWind(message.uMps, message.vMps, wind.mounting);
    if (!wind.series.push(time_s, value.speed_mps, value.from_deg)) return;
    wind.mean.push(time_s, value);
    wind.gust.push(time_s, value.speed_mps);
    wind.seen.see();
  }

  private takeDisplacement(target: Target, message: Displacement): void {
    const lost = !message.valid;
    if (!target.series.push(seconds(message.timestamp), lost ? NaN : message.x, lost ? NaN : message.y)) return;
    target.unit = message.unit;
    target.region = message.region;
    target.health = message.health;
    target.valid = message.valid;
    target.seen.see();
  }

  private takeEstimate(target: Target, message: WindEstimate): void {
    const shown = message.accepted ? message.windMps : NaN;
    if (!target.estimates.push(seconds(message.timestamp), shown, message.windSdMps)) return;
    target.estimate = message;
    target.estimateSeen.see();
  }

  private takeAction(message: OperatorAction): void {
    if (message.kind === ActionKind.removeTarget || message.kind === ActionKind.addTarget) {
      for (const target of this.targets.values()) {
        const isMeant = target.name === message.text && (!message.camera || message.camera === target.device);
        if (isMeant) target.removed = message.kind === ActionKind.removeTarget;
      }
    }
    if (message.kind === ActionKind.mark || message.kind === ActionKind.note) {
      const time_s = seconds(message.timestamp);
      if (!this.marks.some((mark) => mark.time_s === time_s)) this.marks.push({ time_s, text: message.text });
    }
  }

  private takeState(message: DisplayState): void {
    // The daemon tells this before it sends anything of the new place.
    const jumps = this.state?.player?.jumps;
    if (jumps !== undefined && message.player != null && message.player.jumps !== jumps) this.reset();
    this.state = message;
    for (const size of message.pictures) {
      for (const camera of this.cameras.values()) {
        if (`${camera.topic}${kPreview}` !== size.topic) continue;
        camera.width_px = size.width_px;
        camera.height_px = size.height_px;
      }
    }
  }

  private takeMotion(camera: Camera | undefined, message: ImageAnnotations): void {
    if (camera === undefined) return;
    camera.motion = motionOf(message);
    camera.motionSeen.see();
  }

  private takePicture(camera: Camera | undefined, message: CompressedImage): void {
    if (camera === undefined) return;
    camera.pictureSeen.see();
    camera.onPicture?.(message);
  }
}
