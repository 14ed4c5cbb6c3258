// Wind words and numbers from an anemometer's components.

export interface HorizontalWind {
  speed_mps: number;
  from_deg: number; // where it comes from, clockwise from north
}

/** How an anemometer stands: the stream's metadata "axes" and "north_offset_deg" (core/wind_geometry.h). */
export interface Mounting {
  northOffset_deg: number; // azimuth of the instrument's north mark
  axes: string; // "gill_spar", "gill_axis": turned by 30 degrees, or "east_north": by -90
}

export function mountingOf(metadata: Record<string, string>): Mounting {
  const offset = Number(metadata["north_offset_deg"] ?? 0);
  return { northOffset_deg: Number.isFinite(offset) ? offset : 0, axes: metadata["axes"] ?? "gill_spar" };
}

const turnedByAxes_deg: Record<string, number> = { gill_axis: 30, east_north: -90 };

/** Gill's spar axes: u positive blowing towards the instrument's north, v positive blowing towards its west. */
export function horizontalWind(u_mps: number, v_mps: number, mounting: Mounting): HorizontalWind {
  const turned_deg = turnedByAxes_deg[mounting.axes] ?? 0;
  const from_deg = (Math.atan2(v_mps, -u_mps) * 180) / Math.PI - turned_deg + mounting.northOffset_deg;
  return { speed_mps: Math.hypot(u_mps, v_mps), from_deg: ((from_deg % 360) + 360) % 360 };
}

/** The part of the wind that comes from `direction_deg`; negative when it comes from the other side. */
export function componentFrom(wind: HorizontalWind, direction_deg: number): number {
  return wind.speed_mps * Math.cos(((wind.from_deg - direction_deg) * Math.PI) / 180);
}

/** Mean of directions weighted by speed: the direction of the mean vector, and its length. */
export class VectorMean {
  private readonly recent: { time_s: number; east: number; north: number; speed_mps: number }[] = [];
  constructor(private readonly window_s: number) {}

  push(time_s: number, wind: HorizontalWind): void {
    const angle = (wind.from_deg * Math.PI) / 180;
    this.recent.push({
      time_s,
      east: wind.speed_mps * Math.sin(angle),
      north: wind.speed_mps * Math.cos(angle),
      speed_mps: wind.speed_mps,
    });
    while (this.recent.length > 0 && this.recent[0]!.time_s <= time_s - this.window_s) this.recent.shift();
  }

  clear(): void {
    this.recent.length = 0;
  }

  /** Mean scalar speed and direction of the mean vector over the window. */
  mean(): HorizontalWind {
    let east = 0;
    let north = 0;
    let speed = 0;
    for (const one of this.recent) {
      east += one.east;
      north += one.north;
      speed += one.speed_mps;
    }
    const from_deg = ((Math.atan2(east, north) * 180) / Math.PI + 360) % 360;
    return { speed_mps: this.recent.length > 0 ? speed / this.recent.length : NaN, from_deg };
  }
}

/** Gust: the greatest 3 s mean speed in the last ten minutes (WMO). */
export class Gust {
  private readonly short: { time_s: number; speed_mps: number }[] = [];
  private readonly peaks: { time_s: number; mean_mps: number }[] = []; // falling means: the first is the gust
  private sum_mps = 0;
  private first_s = NaN;

  constructor(
    private readonly mean_s = 3,
    private readonly memory_s = 600,
  ) {}

  push(time_s: number, speed_mps: number): void {
    if (!Number.isFinite(speed_mps)) return;
    if (Number.isNaN(this.first_s)) this.first_s = time_s;
    this.short.push({ time_s, speed_mps });
    this.sum_mps += speed_mps;
    while (this.short[0]!.time_s <= time_s - this.mean_s) this.sum_mps -= this.short.shift()!.speed_mps;
    if (time_s - this.first_s < this.mean_s * 0.9) return;
    const mean_mps = this.sum_mps / this.short.length;
    while (this.peaks.length > 0 && this.peaks[this.peaks.length - 1]!.mean_mps <= mean_mps) this.peaks.pop();
    this.peaks.push({ time_s, mean_mps });
    while (this.peaks[0]!.time_s <= time_s - this.memory_s) this.peaks.shift();
  }

  clear(): void {
    this.short.length = 0;
    this.peaks.length = 0;
    this.sum_mps = 0;
    this.first_s = NaN;
  }

  get value_mps(): number {
    return this.peaks[0]?.mean_mps ?? NaN;
  }
}
