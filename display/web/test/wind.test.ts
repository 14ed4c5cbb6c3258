import assert from "node:assert/strict";
import { test } from "node:test";
import { componentFrom, Gust, horizontalWind, mountingOf, VectorMean, type Mounting } from "../src/model/wind.ts";

const spar = (northOffset_deg: number): Mounting => ({ northOffset_deg, axes: "gill_spar" });

test("mounting is read from metadata", () => {
  assert.deepEqual(mountingOf({ north_offset_deg: "235", axes: "gill_axis" }), { northOffset_deg: 235, axes: "gill_axis" });
  assert.deepEqual(mountingOf({ north_offset_deg: "north" }), spar(0));
  // The same wind, seen by a head in AXIS configuration: u_spar = u cos 30 - v sin 30, v_spar = u sin 30 + v cos 30.
  const [u, v] = [1.2, -2.9];
  const cos = Math.cos(Math.PI / 6);
  const turned = horizontalWind(u, v, { northOffset_deg: 10, axes: "gill_axis" });
  const straight = horizontalWind(u * cos - v / 2, u / 2 + v * cos, spar(10));
  assert.ok(Math.abs(turned.from_deg - straight.from_deg) < 1e-9);
  // A line of a TriSonica: S2 02.222 D 255 U 02.142 V 00.592
  assert.ok(Math.abs(horizontalWind(2.142, 0.592, { northOffset_deg: 0, axes: "east_north" }).from_deg - 255) < 0.6);
});

// Gill: u > 0 blows from south to north, v > 0 from east to west.
test("directions are where the wind comes from", () => {
  const cases: [number, number, number][] = [
    [-3, 0, 0], // from the north
    [0, 3, 90], // from the east
    [3, 0, 180],
    [0, -3, 270],
  ];
  for (const [u, v, from] of cases) {
    const wind = horizontalWind(u, v, spar(0));
    assert.ok(Math.abs(wind.from_deg - from) < 1e-9, `${u} ${v}`);
    assert.equal(wind.speed_mps, 3);
  }
  assert.ok(Math.abs(horizontalWind(-3, 0, spar(235)).from_deg - 235) < 1e-9);
  assert.ok(Math.abs(horizontalWind(0, -3, spar(235)).from_deg - 145) < 1e-9);
});

test("the part along a direction", () => {
  assert.ok(Math.abs(componentFrom({ speed_mps: 4, from_deg: 240 }, 240) - 4) < 1e-9);
  assert.ok(Math.abs(componentFrom({ speed_mps: 4, from_deg: 60 }, 240) + 4) < 1e-9);
  assert.ok(Math.abs(componentFrom({ speed_mps: 4, from_deg: 300 }, 240) - 2) < 1e-9);
});

test("the mean goes round north", () => {
  const mean = new VectorMean(3);
  mean.push(0, { speed_mps: 9, from_deg: 180 }); // too old in the end
  mean.push(3, { speed_mps: 2, from_deg: 350 });
  mean.push(4, { speed_mps: 2, from_deg: 10 });
  const { speed_mps, from_deg } = mean.mean();
  assert.equal(speed_mps, 2);
  assert.ok(Math.min(from_deg, 360 - from_deg) < 1e-9);
  assert.ok(Number.isNaN(new VectorMean(3).mean().speed_mps));
});

test("a gust is the greatest 3 s mean of ten minutes", () => {
  const gust = new Gust();
  for (let t = 0; t < 2; t += 0.05) gust.push(t, 20);
  assert.ok(Number.isNaN(gust.value_mps), "too short to tell");
  gust.clear();
  for (let t = 0; t < 100; t += 0.05) gust.push(t, t >= 50 && t < 53 ? 9 : 4);
  assert.ok(Math.abs(gust.value_mps - 9) < 0.1);
  for (let t = 100; t < 660; t += 0.05) gust.push(t, 4);
  assert.ok(Math.abs(gust.value_mps - 4) < 1e-6, "it is forgotten after ten minutes");
});
