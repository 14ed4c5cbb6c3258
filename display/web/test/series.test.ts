import assert from "node:assert/strict";
import { test } from "node:test";
import { align, TimeSeries } from "../src/model/series.ts";

function regular(count: number, interval_s = 0.05): TimeSeries {
  const series = new TimeSeries(1000, 1);
  for (let i = 0; i < count; ++i) series.push(i * interval_s, i);
  return series;
}

test("keeps the newest when full", () => {
  const series = new TimeSeries(3, 1);
  for (let i = 0; i < 5; ++i) series.push(i, 10 * i);
  assert.deepEqual(series.piece(-1, 9), { times: [2, 3, 4], columns: [[20, 30, 40]] });
  assert.equal(series.lastTime, 4);
});

test("takes nothing that is not newer", () => {
  const series = new TimeSeries(10, 1);
  assert.ok(series.push(1, 1));
  assert.equal(series.push(1, 2), false);
  assert.equal(series.push(0.5, 2), false);
  assert.equal(series.push(NaN, 2), false);
  assert.deepEqual(series.piece(0, 9).columns, [[1]]);
});

test("a missing sample leaves a hole", () => {
  const series = regular(20);
  series.push(20.5 * 0.05, 99); // 1.5 intervals late: jitter at worst
  assert.ok(!series.piece(0, 9).columns[0]!.includes(null));
  series.push(series.lastTime + 0.1, 100); // one sample is missing
  const { times, columns } = series.piece(0, 9);
  const hole = columns[0]!.indexOf(null);
  assert.ok(hole > 0);
  assert.equal(columns[0]![hole + 1], 100);
  assert.ok(times[hole]! > times[hole - 1]! && times[hole]! < times[hole + 1]!);
});

test("a long hole does not make the next one look usual", () => {
  const series = regular(20);
  series.push(100, 1);
  series.push(100.05, 2);
  series.push(100.2, 3);
  assert.equal(series.piece(0, 200).columns[0]!.filter((value) => value === null).length, 2);
});

test("values that were not measured are holes", () => {
  const series = new TimeSeries(10, 2);
  series.push(0, 1, 5);
  series.push(1, NaN, 6);
  assert.deepEqual(series.piece(-1, 2).columns, [
    [1, null],
    [5, 6],
  ]);
});

test("a piece reaches one sample beyond both ends", () => {
  const { times } = regular(100).piece(1, 2);
  assert.equal(times[0], 19 * 0.05);
  assert.equal(times.at(-1), 40 * 0.05);
  assert.deepEqual(regular(5).piece(50, 60).times, [0.2]);
  assert.deepEqual(new TimeSeries(5, 1).piece(0, 1), { times: [], columns: [[]] });
});

test("aligned series keep holes apart from other series' times", () => {
  const [times, a, b, c] = align([
    { times: [0, 1, 2], columns: [[1, null, 3]] },
    {
      times: [1, 1.5],
      columns: [
        [5, 6],
        [7, 8],
      ],
    },
  ]);
  assert.deepEqual(times, [0, 1, 1.5, 2]);
  assert.deepEqual(a, [1, null, undefined, 3]);
  assert.deepEqual(b, [undefined, 5, 6, undefined]);
  assert.deepEqual(c, [undefined, 7, 8, undefined]);
  assert.deepEqual(align([{ times: [], columns: [[]] }]), [[], []]);
});

test("values since a time", () => {
  assert.deepEqual(regular(5).valuesSince(0.15), [3, 4]);
});
