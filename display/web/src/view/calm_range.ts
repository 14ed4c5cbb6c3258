// CalmRange: limits of an axis that hold still while the data move: round numbers, widened at once, narrowed only when the
// data have used little of it for a while.

const kPadding = 0.08;
const kWastedShare = 0.45; // narrower than this share of the axis: it may shrink
const kPatience = 40; // updates

/** 1, 2 or 5 times a power of ten, near a quarter of `span`. */
export function roundStep(span: number): number {
  const raw = span / 4;
  const power = 10 ** Math.floor(Math.log10(raw));
  const leading = raw / power;
  return (leading < 1.5 ? 1 : leading < 3.5 ? 2 : leading < 7.5 ? 5 : 10) * power;
}

export class CalmRange {
  private low = NaN;
  private high = NaN;
  private wasted = 0;

  /** `least`: the axis is never narrower. `zero`: 0 is always on it. */
  constructor(
    private readonly least: number,
    private readonly zero: boolean,
  ) {}

  update(low: number, high: number): [number, number] {
    if (!(high >= low)) return Number.isNaN(this.low) ? [0, this.least] : [this.low, this.high];
    const [wantLow, wantHigh] = this.rounded(low, high);
    const fits = low >= this.low && high <= this.high;
    this.wasted = fits && wantHigh - wantLow < kWastedShare * (this.high - this.low) ? this.wasted + 1 : 0;
    if (!fits) {
      const known = !Number.isNaN(this.low);
      this.low = known ? Math.min(this.low, wantLow) : wantLow;
      this.high = known ? Math.max(this.high, wantHigh) : wantHigh;
    } else if (this.wasted > kPatience) {
      this.low = wantLow;
      this.high = wantHigh;
      this.wasted = 0;
    }
    return [this.low, this.high];
  }

  reset(): void {
    this.low = NaN;
    this.high = NaN;
  }

  private rounded(low: number, high: number): [number, number] {
    if (this.zero) {
      low = Math.min(low, 0);
      high = Math.max(high, 0);
    }
    const missing = Math.max(0, this.least - (high - low));
    low -= this.zero && low === 0 ? 0 : missing / 2;
    high += this.zero && low === 0 ? missing : missing / 2;
    const pad = (high - low) * kPadding;
    const step = roundStep(high - low);
    const padLow = this.zero && low === 0 ? 0 : low - pad;
    return [Math.floor(padLow / step) * step, Math.ceil((high + pad) / step) * step];
  }
}
