// Timeline: the part of time that all charts over time show together. It follows the newest data until it is moved.

const kDefaultSpan_s = 60;
const kShortest_s = 2;
const kLongest_s = 1200;
const kCatchUp_s = 0.15; // how smoothly the right edge follows the data

export class Timeline {
  span_s = kDefaultSpan_s;
  /** Right edge; undefined: now. */
  private held_s: number | undefined;
  private shownNow_s = NaN;
  private lastFrame_ms = performance.now();
  onChange: (() => void) | undefined;

  /** Moves "now" towards the newest data; call once a frame. */
  follow(newest_s: number): void {
    const now_ms = performance.now();
    const step_s = Math.min((now_ms - this.lastFrame_ms) / 1000, 1);
    this.lastFrame_ms = now_ms;
    if (!Number.isFinite(newest_s)) return;
    const behind_s = newest_s - this.shownNow_s;
    if (!(Math.abs(behind_s) < 2)) this.shownNow_s = newest_s;
    else this.shownNow_s += behind_s * (1 - Math.exp(-step_s / kCatchUp_s));
  }

  get now_s(): number {
    return this.shownNow_s;
  }
  get to_s(): number {
    return this.held_s ?? this.shownNow_s;
  }
  get from_s(): number {
    return this.to_s - this.span_s;
  }
  get isLive(): boolean {
    return this.held_s === undefined;
  }

  /** `at`: the place that stays where it is, 0 left edge to 1 right edge. Following, the right edge stays now. */
  zoom(factor: number, at: number): void {
    const fixed_s = this.from_s + at * this.span_s;
    this.span_s = Math.min(kLongest_s, Math.max(kShortest_s, this.span_s * factor));
    if (this.held_s !== undefined) this.hold(fixed_s + (1 - at) * this.span_s);
    this.onChange?.();
  }

  pan(by_s: number): void {
    this.hold(this.to_s + by_s);
    this.onChange?.();
  }

  backToNow(): void {
    this.held_s = undefined;
    this.span_s = kDefaultSpan_s;
    this.onChange?.();
  }

  /** Another place in time: what was held is not there any more. */
  release(): void {
    this.held_s = undefined;
    this.onChange?.();
  }

  private hold(to_s: number): void {
    // Pushed against the present, it follows again.
    this.held_s = to_s >= this.shownNow_s ? undefined : to_s;
  }
}

/** Wheel, drag, pinch and double-click on a chart's plotting area. Vertical strokes stay the page's own scrolling. */
export function steer(area: HTMLElement, timeline: Timeline): void {
  const pointers = new Map<number, number>(); // x by pointer
  const place = (x: number): number => {
    const box = area.getBoundingClientRect();
    return Math.min(1, Math.max(0, (x - box.left) / box.width));
  };
  area.style.touchAction = "pan-y";
  area.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      if (Math.abs(event.deltaX) > Math.abs(event.deltaY)) timeline.pan((event.deltaX / area.clientWidth) * timeline.span_s);
      else timeline.zoom(Math.exp(event.deltaY * 0.0015), place(event.clientX));
    },
    { passive: false },
  );
  area.addEventListener("dblclick", () => timeline.backToNow());
  area.addEventListener("pointerdown", (event) => pointers.set(event.pointerId, event.clientX));
  const forget = (event: PointerEvent): void => void pointers.delete(event.pointerId);
  area.addEventListener("pointerup", forget);
  area.addEventListener("pointercancel", forget);
  area.addEventListener("pointerleave", forget);
  area.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (before === undefined) return;
    const others = [...pointers].filter(([id]) => id !== event.pointerId).map(([, x]) => x);
    pointers.set(event.pointerId, event.clientX);
    const other = others[0];
    if (other === undefined) {
      timeline.pan((-(event.clientX - before) / area.clientWidth) * timeline.span_s);
    } else if (Math.abs(event.clientX - other) > 20) {
      timeline.zoom(Math.abs(before - other) / Math.abs(event.clientX - other), place((event.clientX + other) / 2));
    }
  });
}
