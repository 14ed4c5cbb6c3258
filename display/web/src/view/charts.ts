// The three charts of the selected target: wind, displacement (both over the shared time), spectrum.
import { bearing } from "../model/format.ts";
import type { Piece } from "../model/series.ts";
import type { Session } from "../model/session.ts";
import type { Target } from "../model/target.ts";
import { componentFrom } from "../model/wind.ts";
import { CalmRange } from "./calm_range.ts";
import { byId, setClass, setHidden, setText } from "./dom.ts";
import { SpectrumChart, type Quantity } from "./spectrum_chart.ts";
import { StripChart, timeLabel } from "./strip_chart.ts";
import type { Timeline } from "./timeline.ts";

const kUnits = ["", "px", "m", "strain", ""];
const kEmpty = (columns: number): Piece => ({ times: [], columns: Array.from({ length: columns }, () => []) });

export class Charts {
  private readonly wind: StripChart;
  private readonly displacement: StripChart;
  private readonly spectrum: SpectrumChart;
  private readonly windRange = new CalmRange(4, true);
  private readonly displacementRange = new CalmRange(0.02, false);
  private readonly live = byId("back-to-now");
  private readonly quantityButtons = new Map<Quantity, HTMLElement>([
    ["motion", byId("spectrum-motion")],
    ["force", byId("spectrum-force")],
  ]);
  private shownSpectrum: unknown;

  constructor(
    private readonly session: Session,
    private readonly timeline: Timeline,
  ) {
    this.wind = new StripChart({
      place: byId("wind-chart"),
      timeline,
      series: [
        // The thin line over the broad one: where they agree, both are seen.
        { color: "estimated", width: 3.5, legend: byId("legend-estimated") },
        { color: "measured", width: 1.5, legend: byId("legend-measured") },
      ],
      banded: [0],
      range: this.windRange,
      digits: 1,
    });
    this.displacement = new StripChart({
      place: byId("displacement-chart"),
      timeline,
      series: [{ color: "measured", width: 1.5, legend: byId("legend-displacement") }],
      banded: [],
      range: this.displacementRange,
      digits: 2,
    });
    this.spectrum = new SpectrumChart(byId("spectrum-chart"));
    this.live.addEventListener("click", () => timeline.backToNow());
    for (const [quantity, button] of this.quantityButtons) button.addEventListener("click", () => this.show(quantity));
  }

  /** Another target or another run: limits learned from the old one do not matter. */
  reset(): void {
    this.windRange.reset();
    this.displacementRange.reset();
    this.shownSpectrum = undefined;
  }

  /** `target`: the selected one; `source`: whose estimate is shown, it or all together. */
  update(target: Target | undefined, source: Target | undefined): void {
    setHidden(this.live, this.timeline.isLive);
    setText(byId("chart-span"), this.spanWords());
    const marks = this.session.marks;
    this.wind.update([this.estimatedPiece(source), this.measuredPiece(target)], marks);
    this.displacement.update([this.displacementPiece(target)], marks);
    this.updateWords(target, source);
    if (this.shownSpectrum === target?.spectrum && target?.spectrum !== undefined) return;
    this.shownSpectrum = target?.spectrum;
    setHidden(byId("spectrum-empty"), target?.spectrum !== undefined);
    this.spectrum.update(target?.spectrum, target?.identification);
  }

  /** After a change of theme. */
  redraw(): void {
    this.spectrum.redraw();
  }

  private show(quantity: Quantity): void {
    this.spectrum.quantity = quantity;
    this.shownSpectrum = undefined;
    for (const [one, button] of this.quantityButtons) {
      setClass(button, "on", one === quantity);
      button.setAttribute("aria-pressed", String(one === quantity));
    }
  }

  /** The direction the estimate stands for, once it is known by comparison. */
  private direction(target: Target | undefined): number | undefined {
    const direction = target?.calibration?.directionDeg;
    return target?.estimate?.scaleKnown === true && direction !== undefined && Number.isFinite(direction) ? direction : undefined;
  }

  private measuredPiece(target: Target | undefined): Piece {
    const wind = this.session.measuredWind(target);
    if (wind === undefined) return kEmpty(1);
    const piece = wind.series.piece(this.timeline.from_s, this.timeline.to_s);
    const [speeds, directions] = piece.columns as [(number | null)[], (number | null)[]];
    const along = this.direction(target);
    if (along === undefined) return { times: piece.times, columns: [speeds] };
    const component = speeds.map((speed_mps, i) => {
      const from_deg = directions[i];
      return speed_mps === null || from_deg == null ? null : componentFrom({ speed_mps, from_deg }, along);
    });
    return { times: piece.times, columns: [component] };
  }

  private estimatedPiece(target: Target | undefined): Piece {
    if (target === undefined) return kEmpty(3);
    const piece = target.estimates.piece(this.timeline.from_s, this.timeline.to_s);
    const [values, sds] = piece.columns as [(number | null)[], (number | null)[]];
    const edge = (sign: number): (number | null)[] =>
      values.map((value, i) => (value === null || sds[i] == null ? null : value + sign * sds[i]));
    return { times: piece.times, columns: [values, edge(-1), edge(+1)] };
  }

  private displacementPiece(target: Target | undefined): Piece {
    if (target === undefined) return kEmpty(1);
    const piece = target.series.piece(this.timeline.from_s, this.timeline.to_s);
    const [xs, ys] = piece.columns as [(number | null)[], (number | null)[]];
    const axis = target.axis ?? { x: 1, y: 0 };
    const along = xs.map((x, i) => {
      const y = ys[i];
      return x === null || y == null ? null : x * axis.x + y * axis.y;
    });
    return { times: piece.times, columns: [along] };
  }

  private updateWords(target: Target | undefined, source: Target | undefined): void {
    const along = this.direction(target);
    setText(byId("legend-measured-name"), along === undefined ? "measured speed" : `measured along ${bearing(along)}`);
    setText(byId("legend-estimated-name"), source?.estimate?.scaleKnown === false ? "estimated, scale unknown" : "estimated ± sd");
    setText(byId("displacement-title"), target === undefined ? "Displacement" : `Displacement of ${target.name}`);
    const direction = target?.axis === undefined ? "to the right" : "along its main axis";
    setText(byId("displacement-unit"), target === undefined ? "" : `${kUnits[target.unit] ?? ""}, ${direction}`);
    const motion = this.spectrum.quantity === "motion";
    setText(byId("spectrum-measured-name"), motion ? "measured" : "force");
    setText(byId("spectrum-model-name"), motion ? "fitted oscillator" : "what noise would give");
    const unit = kUnits[target?.unit ?? 1] ?? "";
    setText(byId("spectrum-unit"), motion ? `${unit}²/Hz` : `(${unit}/s²)²/Hz`);
  }

  private spanWords(): string {
    const { timeline } = this;
    const span = timeLabel(-timeline.span_s).slice(1);
    if (timeline.isLive) return `last ${span}`;
    return `${span} up to ${timeLabel(timeline.to_s - timeline.now_s)}`;
  }
}
