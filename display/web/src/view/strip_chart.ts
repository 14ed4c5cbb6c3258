// A chart over time on the shared timeline: one or more series, a band, marks, gaps left open.
import uPlot from "uplot";
import { fixed, kMinus } from "../model/format.ts";
import { align, type Piece } from "../model/series.ts";
import type { Mark } from "../model/session.ts";
import { CalmRange } from "./calm_range.ts";
import { setText, themeColor } from "./dom.ts";
import { steer, type Timeline } from "./timeline.ts";

export interface StripSeries {
  color: string; // name of a theme colour
  width: number;
  legend: HTMLElement; // shows the value under the cursor, else the newest
}

export interface StripOptions {
  place: HTMLElement;
  timeline: Timeline;
  series: StripSeries[];
  /** Series (by index) whose piece has three columns: value, low and high of a band. */
  banded: number[];
  range: CalmRange;
  digits: number;
}

/** "−45 s", "−2 min", "now". */
export function timeLabel(offset_s: number): string {
  const rounded = Math.round(offset_s * 10) / 10;
  if (Math.abs(rounded) < 0.05) return "now";
  const sign = rounded < 0 ? kMinus : "+";
  const size = Math.abs(rounded);
  if (size < 120) return `${sign}${size % 1 === 0 ? size : size.toFixed(1)} s`;
  const seconds = Math.round(size % 60);
  return `${sign}${Math.floor(size / 60)} min${seconds > 0 ? ` ${seconds} s` : ""}`;
}

const kSteps_s = [0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300];

/** Ticks at round distances from `now_s`. */
export function timeTicks(from_s: number, to_s: number, now_s: number, most: number): number[] {
  const step = kSteps_s.find((candidate) => (to_s - from_s) / candidate <= most) ?? 600;
  const ticks: number[] = [];
  for (let k = Math.ceil((from_s - now_s) / step); now_s + k * step <= to_s + 1e-6; ++k) ticks.push(now_s + k * step);
  return ticks;
}

export class StripChart {
  private readonly plot: uPlot;
  private marks: Mark[] = [];
  private data: uPlot.AlignedData = [[]];
  private columnOf: number[] = []; // series index -> its value's column

  constructor(private readonly options: StripOptions) {
    this.plot = new uPlot(this.makeOptions(), this.data, options.place);
    steer(this.plot.over, options.timeline);
    new ResizeObserver(() => this.resize()).observe(options.place);
  }

  /** One piece per series; a banded one has three columns. */
  update(pieces: Piece[], marks: Mark[]): void {
    this.marks = marks;
    this.data = align(pieces) as uPlot.AlignedData;
    this.plot.setData(this.data, true);
    this.showValues();
  }

  private makeOptions(): uPlot.Options {
    const { timeline, banded } = this.options;
    const series: uPlot.Series[] = [{}];
    const bands: uPlot.Band[] = [];
    this.options.series.forEach((one, i) => {
      this.columnOf.push(series.length);
      const stroke = (): string => themeColor(one.color);
      series.push({ stroke, width: one.width, points: { show: false }, spanGaps: false });
      if (!banded.includes(i)) return;
      const low = series.length;
      series.push({ stroke: "transparent", width: 0, points: { show: false } });
      series.push({ stroke: "transparent", width: 0, points: { show: false } });
      bands.push({ series: [low + 1, low], fill: () => `${themeColor(one.color)}40` });
    });
    return {
      width: this.options.place.clientWidth || 400,
      height: this.options.place.clientHeight || 160,
      legend: { show: false },
      padding: [8, 26, 0, 0],
      cursor: { drag: { x: false, y: false, setScale: false }, points: { show: false }, y: false, sync: { key: "time" } },
      scales: {
        x: { time: false, range: () => [timeline.from_s, timeline.to_s] },
        y: { range: (_plot, low, high) => this.options.range.update(low ?? NaN, high ?? NaN) },
      },
      axes: [this.timeAxis(), this.valueAxis()],
      series,
      bands,
      hooks: { draw: [(plot) => this.drawMarks(plot)], setCursor: [() => this.showValues()] },
    };
  }

  private timeAxis(): uPlot.Axis {
    const { timeline } = this.options;
    const most = (): number => Math.max(2, Math.floor((this.options.place.clientWidth || 400) / 90));
    return {
      ...axisLook(),
      size: 28,
      splits: () => timeTicks(timeline.from_s, timeline.to_s, timeline.now_s, most()),
      values: (_plot, splits) => splits.map((time) => timeLabel(time - timeline.now_s)),
    };
  }

  private valueAxis(): uPlot.Axis {
    return { ...axisLook(), size: 46, space: 24, values: (_plot, splits) => splits.map((value) => trimmed(value)) };
  }

  private showValues(): void {
    const times = this.data[0];
    const cursor = this.plot?.cursor.idx;
    this.options.series.forEach((one, i) => {
      const column = this.data[this.columnOf[i]!];
      const value = column === undefined ? null : valueNear(times, column, cursor ?? times.length - 1);
      setText(one.legend, value == null ? "–" : fixed(value, this.options.digits));
    });
  }

  private drawMarks(plot: uPlot): void {
    const { ctx, bbox } = plot;
    const { timeline } = this.options;
    const scale = window.devicePixelRatio || 1;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = themeColor("text");
    ctx.lineWidth = scale;
    ctx.font = `600 ${11 * scale}px system-ui, sans-serif`;
    ctx.textAlign = "left";
    ctx.textBaseline = "alphabetic";
    for (const mark of this.marks) {
      if (mark.time_s < timeline.from_s || mark.time_s > timeline.to_s) continue;
      const x = Math.round(plot.valToPos(mark.time_s, "x", true));
      ctx.setLineDash([4 * scale, 4 * scale]);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      ctx.fillText(mark.text === "" ? "M" : mark.text.slice(0, 16), x + 4 * scale, bbox.top + 11 * scale);
    }
    ctx.restore();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.options.place;
    if (width > 0 && height > 0) this.plot.setSize({ width, height });
  }
}

/** The axes' common look; colours are asked for at every drawing, so that a change of theme shows. */
export function axisLook(): uPlot.Axis {
  return {
    stroke: () => themeColor("muted"),
    font: "13px system-ui, sans-serif",
    gap: 4,
    grid: { stroke: () => themeColor("grid"), width: 1 },
    ticks: { show: false },
  };
}

function trimmed(value: number): string {
  return String(Math.round(value * 1e6) / 1e6).replace("-", kMinus);
}

const kSameTime_s = 1;

/** The value at `index`, or the last one shortly before it: other series have times in between. A hole has none. */
function valueNear(times: ArrayLike<number>, column: ArrayLike<number | null | undefined>, index: number): number | null {
  for (let i = Math.min(index, column.length - 1); i >= 0 && times[i]! > times[index]! - kSameTime_s; --i) {
    const value = column[i];
    if (value !== undefined) return value;
  }
  return null;
}
