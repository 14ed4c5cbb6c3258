// The wind: measured and estimated, in numbers that can be read from across the field, and how far to believe the estimate.
import { bearing, fixed, percent, roughDuration, withSd } from "../model/format.ts";
import type { WindCalibration, WindEstimate } from "../model/messages.ts";
import type { Session } from "../model/session.ts";
import type { Target, WindStream } from "../model/target.ts";
import { byId, setClass, setHidden, setText } from "./dom.ts";

const kStale_s = 2;
const kEstimateStale_s = 3;
const kEnough_s = 30; // of compared data before a share is worth telling

/** Why there is no estimate and what to do about it; nothing when there is one. */
export function reasonForNone(target: Target | undefined, session: Session): string | undefined {
  if (target === undefined) {
    return session.isReplay ? "Nothing is tracked in this recording." : "No target yet: draw a rectangle around a branch in a picture.";
  }
  if (session.age_s(target.seen, target.series) > kEstimateStale_s) return `${target.name} sends no motion: check its camera.`;
  if (!target.valid) return `${target.name} is lost from sight: draw its rectangle again.`;
  const known = target.identification;
  if (known === undefined) return `Listening to ${target.name}: a first answer needs about half a minute of motion.`;
  if (!known.accepted) {
    const peak = Number.isFinite(known.peakToFloor) ? ` (peak ${fixed(known.peakToFloor, 1)} × the noise)` : "";
    return `The resonance of ${target.name} does not stand out of the noise yet${peak}: more wind or more time helps.`;
  }
  if (session.age_s(target.estimateSeen, target.estimates) > kEstimateStale_s || target.estimate === undefined) {
    return `${target.name} is known; its wind is being worked out.`;
  }
  if (!target.estimate.accepted) return `The estimate of ${target.name} does not fit its motion just now.`;
  return undefined;
}

export class WindPanel {
  private readonly measured = byId("wind-measured");
  private readonly speed = byId("wind-speed");
  private readonly from = byId("wind-from");
  private readonly gust = byId("wind-gust");
  private readonly age = byId("wind-age");
  private readonly arrow = byId("wind-arrow");
  private readonly estimated = byId("wind-estimated");
  private readonly title = byId("estimate-title");
  private readonly value = byId("estimate-value");
  private readonly unit = byId("estimate-unit");
  private readonly settling = byId("estimate-settling");
  private readonly trust = byId("estimate-trust");
  private readonly reason = byId("estimate-reason");

  constructor(private readonly session: Session) {}

  /** `target`: the selected one; `source`: whose estimate is shown, it or all together. */
  update(target: Target | undefined, source: Target | undefined, paused: boolean): void {
    this.updateMeasured(this.session.measuredWind(target), paused);
    setText(this.title, source === undefined ? "Estimated from the motion" : `Estimated from ${source.name}`);
    this.updateEstimate(target, source?.estimate, source === this.session.fused, paused);
  }

  private updateMeasured(wind: WindStream | undefined, paused: boolean): void {
    const mean = wind?.mean.mean();
    const age_s = wind === undefined ? Infinity : this.session.age_s(wind.seen, wind.series);
    const stale = age_s > kStale_s && !paused;
    setClass(this.measured, "stale", stale);
    setText(this.speed, mean === undefined ? "–" : fixed(mean.speed_mps, 1));
    setText(this.from, mean === undefined || !(mean.speed_mps > 0) ? "–" : `from ${bearing(mean.from_deg)}`);
    setText(this.gust, wind === undefined ? "–" : fixed(wind.gust.value_mps, 1));
    const silent = Number.isFinite(age_s) ? `${roughDuration(age_s)} old: the anemometer is silent` : "waiting for the anemometer";
    setText(this.age, wind === undefined ? "no anemometer here" : stale ? silent : "");
    // The arrow flies with the wind: from where it comes to where it goes.
    if (mean !== undefined && mean.speed_mps > 0) {
      this.arrow.style.transform = `rotate(${Math.round(mean.from_deg)}deg)`;
    }
    setClass(this.arrow, "none", mean === undefined || !(mean.speed_mps > 0));
  }

  private updateEstimate(target: Target | undefined, estimate: WindEstimate | undefined, fused: boolean, paused: boolean): void {
    const reason = fused || (paused && estimate?.accepted) ? undefined : reasonForNone(target, this.session);
    const shown = reason === undefined && estimate !== undefined;
    setClass(this.estimated, "none", !shown);
    setHidden(this.reason, shown);
    setText(this.reason, reason ?? "");
    setHidden(this.settling, !(shown && estimate.settling));
    setHidden(this.unit, !shown);
    setHidden(this.trust, !shown);
    if (!shown || target === undefined) {
      setText(this.value, "–");
      return;
    }
    setText(this.value, withSd(estimate.windMps, estimate.windSdMps, 1));
    setText(this.unit, estimate.scaleKnown ? "m/s" : "× an unknown scale");
    setText(this.trust, trustWords(target.calibration, estimate));
  }
}

function trustWords(calibration: WindCalibration | undefined, estimate: WindEstimate): string {
  const lag = `${fixed(estimate.lagS, 2)} s behind`;
  if (!estimate.scaleKnown) return `no reference wind to set the scale by; ${lag}`;
  if (calibration === undefined || !Number.isFinite(calibration.explained) || calibration.secondsUsed < kEnough_s) {
    return `being compared with the measured wind; ${lag}`;
  }
  const along = Number.isFinite(calibration.directionDeg) ? ` along ${bearing(calibration.directionDeg)}` : "";
  return `explains ${percent(calibration.explained)} of ${roughDuration(calibration.secondsUsed)}${along}; ${lag}`;
}
