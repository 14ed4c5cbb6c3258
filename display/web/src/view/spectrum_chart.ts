// The selected target's power spectrum, log-log: what was measured, the fitted oscillator, the band in which the force can be
// trusted, and the natural frequency.
import uPlot from "uplot";
import type { ForceSpectrum, Identification } from "../model/messages.ts";
import { fixed } from "../model/format.ts";
import { axisLook } from "./strip_chart.ts";
import { themeColor } from "./dom.ts";

export type Quantity = "motion" | "force";

const kSuperscripts = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/** "10⁻³". */
export function powerOfTen(exponent: number): string {
  const digits = String(Math.abs(exponent)).replace(/\d/g, (digit) => kSuperscripts[Number(digit)]!);
  return `10${exponent < 0 ? "⁻" : ""}${digits}`;
}

/** Limits in whole decades around the positive values; the lowest are noise of no interest: at most six decades. */
export function decades(low: number, high: number): [number, number] {
  const top = Math.ceil(Math.log10(high > 0 ? high : 1) + 0.1);
  const bottom = Math.floor(Math.log10(low > 0 ? low : high / 1e3) - 0.1);
  return [10 ** Math.max(bottom, top - 6), 10 ** top];
}

export class SpectrumChart {
  quantity: Quantity = "motion";
  private readonly plot: uPlot;
  private spectrum: ForceSpectrum | undefined;
  private identification: Identification | undefined;
  private range: [number, number] = [1e-3, 1];

  constructor(private readonly place: HTMLElement) {
    this.plot = new uPlot(this.makeOptions(), [[], [], []], place);
    new ResizeObserver(() => {
      if (place.clientWidth > 0 && place.clientHeight > 0) {
        this.plot.setSize({ width: place.clientWidth, height: place.clientHeight });
      }
    }).observe(place);
  }

  update(spectrum: ForceSpectrum | undefined, identification: Identification | undefined): void {
    this.spectrum = spectrum;
    this.identification = identification;
    const positive = (values: number[]): (number | null)[] => values.map((value) => (value > 0 ? value : null));
    if (spectrum === undefined) {
      this.plot.setData([[], [], []], true);
      return;
    }
    // Frequency 0 has no place on a logarithmic axis.
    const first = spectrum.frequencyHz.findIndex((frequency) => frequency > 0);
    const measured = this.quantity === "motion" ? spectrum.displacementPower : spectrum.forcePower;
    const model = this.quantity === "motion" ? spectrum.modelPower : spectrum.forceNoisePower;
    const shown = [...measured, ...model].filter((value) => value > 0);
    if (shown.length > 0) this.range = decades(Math.min(...shown), Math.max(...shown));
    this.plot.setData(
      [spectrum.frequencyHz.slice(first), positive(model.slice(first)), positive(measured.slice(first))] as uPlot.AlignedData,
      true,
    );
  }

  redraw(): void {
    this.plot.redraw();
  }

  private makeOptions(): uPlot.Options {
    return {
      width: this.place.clientWidth || 400,
      height: this.place.clientHeight || 180,
      legend: { show: false },
      padding: [8, 26, 0, 0],
      cursor: { drag: { x: false, y: false, setScale: false }, points: { show: false }, show: false },
      scales: {
        x: { time: false, distr: 3, range: (_plot, low, high) => [Math.max(low || 0.05, 0.02), high || 10] },
        y: { distr: 3, range: () => this.range },
      },
      axes: [
        {
          ...axisLook(),
          size: 28,
          filter: (_plot, splits) => splits,
          splits: () => [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50].filter((f) => this.inFrequencyRange(f)),
          values: (_plot, splits) => splits.map((frequency, i) => (i === splits.length - 1 ? `${frequency} Hz` : `${frequency}`)),
        },
        {
          ...axisLook(),
          size: 46,
          filter: (_plot, splits) => splits,
          splits: () => wholeDecades(this.range),
          values: (_plot, splits) => splits.map((value) => powerOfTen(Math.round(Math.log10(value)))),
        },
      ],
      series: [
        {},
        { stroke: () => themeColor("estimated"), width: 3.5, points: { show: false } },
        { stroke: () => themeColor("measured"), width: 1.5, points: { show: false } },
      ],
      hooks: { drawClear: [(plot) => this.drawTrust(plot)], draw: [(plot) => this.drawPeak(plot)] },
    };
  }

  private inFrequencyRange(frequency: number): boolean {
    const { min, max } = this.plot.scales["x"]!;
    return frequency >= (min ?? 0) && frequency <= (max ?? Infinity);
  }

  private drawTrust(plot: uPlot): void {
    const spectrum = this.spectrum;
    if (spectrum === undefined || !(spectrum.trustHighHz > spectrum.trustLowHz)) return;
    const { ctx, bbox } = plot;
    const right = bbox.left + bbox.width;
    const from = clamp(plot.valToPos(Math.max(spectrum.trustLowHz, 1e-3), "x", true), bbox.left, right);
    const to = clamp(plot.valToPos(spectrum.trustHighHz, "x", true), bbox.left, right);
    const scale = window.devicePixelRatio || 1;
    ctx.save();
    ctx.fillStyle = themeColor("trust");
    ctx.fillRect(from, bbox.top, to - from, bbox.height);
    ctx.fillStyle = themeColor("muted");
    ctx.font = `${12 * scale}px system-ui, sans-serif`;
    ctx.textAlign = "left";
    ctx.textBaseline = "alphabetic";
    if (to - from > 80 * scale) ctx.fillText("trusted", from + 6 * scale, bbox.top + bbox.height - 7 * scale);
    ctx.restore();
  }

  private drawPeak(plot: uPlot): void {
    const frequency = this.identification?.naturalFrequencyHz ?? NaN;
    if (this.spectrum === undefined || !this.inFrequencyRange(frequency)) return;
    const { ctx, bbox } = plot;
    const scale = window.devicePixelRatio || 1;
    const x = Math.round(plot.valToPos(frequency, "x", true));
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = themeColor("text");
    ctx.lineWidth = 1.5 * scale;
    ctx.setLineDash([5 * scale, 4 * scale]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.font = `600 ${13 * scale}px system-ui, sans-serif`;
    const label = `${fixed(frequency, 2)} Hz`;
    const width = ctx.measureText(label).width + 12 * scale;
    const onLeft = x + width > bbox.left + bbox.width;
    ctx.textAlign = onLeft ? "right" : "left";
    ctx.fillText(label, x + (onLeft ? -6 : 6) * scale, bbox.top + 14 * scale);
    ctx.restore();
  }
}

function wholeDecades([low, high]: [number, number]): number[] {
  const first = Math.round(Math.log10(low));
  const last = Math.round(Math.log10(high));
  const step = last - first > 4 ? 2 : 1;
  const out: number[] = [];
  for (let exponent = first; exponent <= last; exponent += step) out.push(10 ** exponent);
  return out;
}

function clamp(value: number, low: number, high: number): number {
  return Math.min(high, Math.max(low, value));
}
