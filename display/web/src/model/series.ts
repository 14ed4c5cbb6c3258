// A series of samples in time order, the newest kept, with its holes known: what is missing is drawn as missing.

/** A piece of a series. A row of nulls stands in every hole. */
export interface Piece {
  times: number[];
  columns: (number | null)[][];
}

const kHoleFactor = 1.7; // intervals longer than so many usual ones are holes
const kSmoothing = 0.05;

export class TimeSeries {
  private readonly times: Float64Array;
  private readonly values: Float64Array[];
  private start = 0;
  private count = 0;
  private usualInterval_s = NaN;

  constructor(
    private readonly capacity: number,
    columns: number,
  ) {
    this.times = new Float64Array(capacity);
    this.values = Array.from({ length: columns }, () => new Float64Array(capacity));
  }

  get size(): number {
    return this.count;
  }

  get lastTime(): number {
    return this.count === 0 ? -Infinity : this.timeAt(this.count - 1);
  }

  clear(): void {
    this.start = 0;
    this.count = 0;
    this.usualInterval_s = NaN;
  }

  /** False, and nothing done, when the sample is not newer than the last: history and live messages may overlap. */
  push(time_s: number, ...row: number[]): boolean {
    if (!(time_s > this.lastTime)) return false;
    if (this.count > 0) this.learnInterval(time_s - this.lastTime);
    const at = (this.start + this.count) % this.capacity;
    this.times[at] = time_s;
    this.values.forEach((column, i) => (column[at] = row[i] ?? NaN));
    if (this.count < this.capacity) ++this.count;
    else this.start = (this.start + 1) % this.capacity;
    return true;
  }

  /** The samples from `from_s` to `to_s` and one beyond each end, so that lines run to the picture's edge. */
  piece(from_s: number, to_s: number): Piece {
    const first = Math.max(0, this.lowerBound(from_s) - 1);
    const last = Math.min(this.count, this.lowerBound(to_s) + 1);
    const piece: Piece = { times: [], columns: this.values.map(() => []) };
    const hole_s = this.usualInterval_s * kHoleFactor;
    for (let i = first; i < last; ++i) {
      const time_s = this.timeAt(i);
      const before_s = i > first ? this.timeAt(i - 1) : time_s;
      if (time_s - before_s > hole_s) {
        piece.times.push((time_s + before_s) / 2);
        for (const column of piece.columns) column.push(null);
      }
      piece.times.push(time_s);
      piece.columns.forEach((column, c) => {
        const value = this.values[c]![(this.start + i) % this.capacity]!;
        column.push(Number.isFinite(value) ? value : null);
      });
    }
    return piece;
  }

  /** Every finite value of a column newer than `from_s`. */
  valuesSince(from_s: number, column = 0): number[] {
    const out: number[] = [];
    for (let i = this.lowerBound(from_s); i < this.count; ++i) {
      const value = this.values[column]![(this.start + i) % this.capacity]!;
      if (Number.isFinite(value)) out.push(value);
    }
    return out;
  }

  private timeAt(index: number): number {
    return this.times[(this.start + index) % this.capacity]!;
  }

  /** Index of the first sample at or after `time_s`. */
  private lowerBound(time_s: number): number {
    let low = 0;
    let high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.timeAt(middle) < time_s) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  private learnInterval(interval_s: number): void {
    if (Number.isNaN(this.usualInterval_s)) this.usualInterval_s = interval_s;
    // Bounded, so that one long hole does not make the next ones look usual.
    const bounded_s = Math.min(interval_s, 2 * this.usualInterval_s);
    this.usualInterval_s += kSmoothing * (bounded_s - this.usualInterval_s);
  }
}

/**
 * Several pieces on one axis of time, as uPlot wants them: one array of times, one of values per column. `undefined` where
 * another piece has a time and this one has not: the line runs on; null where a hole is: it stops.
 */
export function align(pieces: Piece[]): [number[], ...(number | null | undefined)[][]] {
  const times = mergeTimes(pieces.map((piece) => piece.times));
  const columns: (number | null | undefined)[][] = [];
  for (const piece of pieces) {
    const places = placesIn(times, piece.times);
    for (const column of piece.columns) {
      const spread = new Array<number | null | undefined>(times.length).fill(undefined);
      places.forEach((place, i) => (spread[place] = column[i]));
      columns.push(spread);
    }
  }
  return [times, ...columns];
}

function mergeTimes(lists: number[][]): number[] {
  const all = lists.flat().sort((a, b) => a - b);
  return all.filter((time, i) => i === 0 || time !== all[i - 1]);
}

function placesIn(times: number[], subset: number[]): number[] {
  let at = 0;
  return subset.map((time) => {
    while (times[at] !== time) ++at;
    return at;
  });
}
