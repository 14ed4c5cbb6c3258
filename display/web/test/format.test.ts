import assert from "node:assert/strict";
import { test } from "node:test";
import * as format from "../src/model/format.ts";
import { powerOfTen, decades } from "../src/view/spectrum_chart.ts";
import { timeLabel, timeTicks } from "../src/view/strip_chart.ts";
import { CalmRange, roundStep } from "../src/view/calm_range.ts";

test("numbers", () => {
  assert.equal(format.fixed(6.44, 1), "6.4");
  assert.equal(format.fixed(-0.34, 1), "−0.3");
  assert.equal(format.fixed(-0.04, 1), "0.0");
  assert.equal(format.fixed(NaN, 1), "–");
});

test("no more digits than are true", () => {
  assert.equal(format.withSd(6.1234, 0.41), "6.1 ± 0.4");
  assert.equal(format.withSd(0.52034, 0.0061), "0.520 ± 0.006");
  assert.equal(format.withSd(0.52034, 0.012), "0.520 ± 0.012");
  assert.equal(format.withSd(123.4, 17), "123 ± 17");
  assert.equal(format.withSd(6.1, 0.041, 1), "6.1 ± 0.0");
  assert.equal(format.withSd(6.1234, NaN, 1), "6.1 ± –");
});

test("times", () => {
  assert.equal(format.clockDuration(761.9), "00:12:41");
  assert.equal(format.clockDuration(360000), "100:00:00");
  assert.equal(format.roughDuration(4.2), "4 s");
  assert.equal(format.roughDuration(600), "10 min");
  assert.equal(format.roughDuration(3 * 3600 + 20 * 60), "3 h 20 min");
  assert.equal(format.roughDuration(72 * 3600), "3 days");
  assert.equal(format.smallTime(8e-5), "80 µs");
  assert.equal(format.smallTime(2.1e-4), "0.21 ms");
  assert.equal(format.smallTime(0.033), "33 ms");
  assert.equal(timeLabel(0), "now");
  assert.equal(timeLabel(-15), "−15 s");
  assert.equal(timeLabel(-0.5), "−0.5 s");
  assert.equal(timeLabel(-150), "−2 min 30 s");
});

test("sizes, rates, bearings", () => {
  assert.equal(format.bytes(212e9), "212 GB");
  assert.equal(format.bytes(1500), "1.5 kB");
  assert.equal(format.bytes(7), "7 B");
  assert.equal(format.rate(29.97), "30.0/s");
  assert.equal(format.rate(120.4), "120/s");
  assert.equal(format.bearing(359.7), "000°");
  assert.equal(format.bearing(-10), "350°");
  assert.equal(format.percent(0.914), "91 %");
  assert.equal(format.fileName("/data/storm-03.mcap"), "storm-03.mcap");
});

test("time ticks stand at round distances from now", () => {
  assert.deepEqual(timeTicks(943.5, 1003.5, 1003.5, 6), [943.5, 953.5, 963.5, 973.5, 983.5, 993.5, 1003.5]);
  assert.ok(timeTicks(0, 1200, 1200, 6).length <= 7);
});

test("powers and decades", () => {
  assert.equal(powerOfTen(-12), "10⁻¹²");
  assert.equal(powerOfTen(3), "10³");
  assert.deepEqual(decades(2e-3, 40), [1e-3, 100]);
  const [low, high] = decades(1e-30, 40);
  assert.ok(Math.abs(Math.log10(high / low) - 6) < 1e-9);
});

test("axis limits are round and hold still", () => {
  assert.equal(roundStep(10), 2);
  const range = new CalmRange(4, true);
  const first = range.update(2.1, 7.3);
  assert.equal(first[0], 0);
  assert.ok(first[1] >= 7.3 && first[1] <= 10);
  assert.deepEqual(range.update(3, 6.9), first);
  const wider = range.update(3, 14);
  assert.ok(wider[1] >= 14);
  for (let i = 0; i < 20; ++i) assert.deepEqual(range.update(1, 3), wider);
  for (let i = 0; i < 40; ++i) range.update(1, 3);
  assert.ok(range.update(1, 3)[1] < wider[1]);
  assert.ok(range.update(-3, 3)[0] <= -3);
  const empty = new CalmRange(4, true);
  assert.deepEqual(empty.update(NaN, NaN), [0, 4]);
});
