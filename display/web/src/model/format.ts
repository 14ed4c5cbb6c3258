// Numbers and times as people read them: with units, steady in width, no more digits than are true.

export const kMinus = "\u2212";
export const kThinSpace = "\u202f";
const kNoValue = "\u2013";

/** "6.4", "−0.3"; a dash for what was not measured. */
export function fixed(value: number, digits: number): string {
  if (!Number.isFinite(value)) return kNoValue;
  const text = Math.abs(value).toFixed(digits);
  const negative = value < 0 && Number(text) !== 0;
  return (negative ? kMinus : "") + text;
}

/** As many decimals as a value known to ±sd deserves: its sd to one digit (two where it begins with 1), at most `most`. */
export function digitsFor(sd: number, most = 3): number {
  if (!(sd > 0) || !Number.isFinite(sd)) return most;
  const exponent = Math.floor(Math.log10(sd));
  const leading = sd / 10 ** exponent;
  const digits = -exponent + (leading < 2 ? 1 : 0);
  return Math.min(most, Math.max(0, digits));
}

/** "6.1 ± 0.4". */
export function withSd(value: number, sd: number, most = 3): string {
  const digits = digitsFor(sd, most);
  return `${fixed(value, digits)} ± ${fixed(sd, digits)}`;
}

/** "00:12:41". */
export function clockDuration(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds));
  const parts = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return parts.map((part) => String(part).padStart(2, "0")).join(":");
}

/** "4 s", "3 min", "2 h 5 min": how long something lasts or lies back. */
export function roughDuration(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  if (whole < 90) return `${whole} s`;
  const minutes = Math.round(whole / 60);
  if (minutes < 90) return `${minutes} min`;
  const hours = Math.floor(minutes / 60);
  if (hours < 48) return `${hours} h ${minutes % 60} min`;
  return `${Math.floor(hours / 24)} days`;
}

export function bytes(count: number): string {
  if (!Number.isFinite(count)) return kNoValue;
  const units = ["B", "kB", "MB", "GB", "TB"];
  let unit = 0;
  let value = count;
  while (value >= 1000 && unit < units.length - 1) {
    value /= 1000;
    ++unit;
  }
  return `${value.toFixed(unit === 0 || value >= 100 ? 0 : 1)} ${units[unit]!}`;
}

/** Events per second: "30.0/s", "120/s". */
export function rate(rate_hz: number): string {
  return `${fixed(rate_hz, rate_hz >= 100 ? 0 : 1)}/s`;
}

/** Small times: "0.08 ms", "12 µs". */
export function smallTime(seconds: number): string {
  const magnitude = Math.abs(seconds);
  if (!Number.isFinite(seconds)) return kNoValue;
  if (magnitude < 1e-4) return `${fixed(seconds * 1e6, magnitude < 1e-5 ? 1 : 0)} µs`;
  if (magnitude < 1) return `${fixed(seconds * 1e3, magnitude < 1e-2 ? 2 : 0)} ms`;
  return `${fixed(seconds, 1)} s`;
}

/** "243°": whole degrees, 0 to 359. */
export function bearing(degrees: number): string {
  if (!Number.isFinite(degrees)) return kNoValue;
  const whole = ((Math.round(degrees) % 360) + 360) % 360;
  return `${String(whole).padStart(3, "0")}°`;
}

export function percent(fraction: number): string {
  return Number.isFinite(fraction) ? `${Math.round(fraction * 100)} %` : kNoValue;
}

/** The time of day here, "13:41:07", of nanoseconds since 1970. */
export function timeOfDay(civil_ns: number): string {
  const date = new Date(civil_ns / 1e6);
  return [date.getHours(), date.getMinutes(), date.getSeconds()].map((n) => String(n).padStart(2, "0")).join(":");
}

/** Last part of a path. */
export function fileName(path: string): string {
  return path.slice(path.lastIndexOf("/") + 1);
}
