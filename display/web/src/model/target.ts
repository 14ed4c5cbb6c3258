// What the page knows about one tracked target and about one wind stream.
import type { ForceSpectrum, Identification, ImageRect, WindCalibration, WindEstimate } from "./messages.ts";
import { TimeSeries } from "./series.ts";
import { Gust, VectorMean, type Mounting } from "./wind.ts";

const kCapacity = 60_000; // 20 min at 50/s

/** Age in real seconds; a message marks it seen. */
export class Freshness {
  private seenAt_ms = -Infinity;
  see(): void {
    this.seenAt_ms = performance.now();
  }
  get age_s(): number {
    return (performance.now() - this.seenAt_ms) / 1000;
  }
}

export class Target {
  readonly series = new TimeSeries(kCapacity, 2); // x, y
  readonly estimates = new TimeSeries(kCapacity, 2); // wind along the axis, its standard deviation
  readonly seen = new Freshness();
  readonly estimateSeen = new Freshness();
  identification: Identification | undefined;
  estimate: WindEstimate | undefined;
  calibration: WindCalibration | undefined;
  spectrum: ForceSpectrum | undefined;
  region: ImageRect | undefined;
  unit = 1;
  health = 1;
  valid = true;
  removed = false;

  constructor(
    readonly key: string, // the part of its topics before the last '/'
    readonly name: string,
    readonly device: string,
  ) {}

  clear(): void {
    this.series.clear();
    this.estimates.clear();
    this.identification = undefined;
    this.estimate = undefined;
    this.calibration = undefined;
    this.spectrum = undefined;
  }

  /** Unit vector of the main motion, once identified. */
  get axis(): { x: number; y: number } | undefined {
    const axis = this.identification?.axis;
    return axis !== undefined && Math.hypot(axis.x, axis.y) > 0.5 ? axis : undefined;
  }
}

const kImported = "/displacement/";

/**
 * What a target's topics have in common: "/camera0/target/branch/displacement" and ".../wind" -> "/camera0/target/branch".
 * An imported series is "/displacement/tree" itself, and its results lie below it.
 */
export function targetKey(topic: string): string {
  if (topic.startsWith(kImported) && !topic.slice(kImported.length).includes("/")) return topic;
  const cut = topic.lastIndexOf("/");
  return cut > 0 ? topic.slice(0, cut) : topic;
}

export function targetName(key: string): string {
  return key.slice(key.lastIndexOf("/") + 1);
}

const kShownMean_s = 3; // what the big number is the mean of: a 20 Hz value cannot be read

export class WindStream {
  readonly series = new TimeSeries(kCapacity, 2); // speed, direction (from)
  readonly mean = new VectorMean(kShownMean_s);
  readonly gust = new Gust();
  readonly seen = new Freshness();

  constructor(
    readonly topic: string,
    readonly device: string,
    readonly mounting: Mounting,
  ) {}

  clear(): void {
    this.series.clear();
    this.mean.clear();
    this.gust.clear();
  }
}
