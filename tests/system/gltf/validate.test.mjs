// Trees written by the program, put before Khronos's own glTF validator: not one error, warning or hint.
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import validator from "gltf-validator";

const program = join(process.env.ROSEAU_BIN, "roseau");
const folder = mkdtempSync(join(tmpdir(), "roseau-gltf-"));

async function validate(name, args) {
  const file = join(folder, name);
  const figures = JSON.parse(execFileSync(program, ["tree", ...args, "--gltf", file, "--json"]));
  assert.equal(figures.gltf, file);
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 20 });
  assert.deepEqual(report.issues.messages, []);
  assert.equal(report.info.version, "2.0");
  return { figures, info: report.info };
}

try {
  const grown = await validate("grown.glb", ["--grow", "--seed", "3"]);
  assert.equal(grown.figures.statistics.height_m, 5.5);
  assert.equal(grown.info.materialCount, 2);
  assert.ok(grown.info.totalTriangleCount >= 4 * grown.figures.statistics.leaves);

  const small = await validate("small.glb", ["--grow", "--simplify", "50"]);
  assert.equal(small.figures.statistics.nodes, 50);
  assert.equal(small.figures.statistics.leaves, grown.figures.statistics.leaves);

  const table = join(folder, "two.txt");
  writeFileSync(table, "0.1 2 0 0 0 0 0 1 0\n0.05 1 0 0 2 0 1 0 1\n");
  const scanned = await validate("scanned.glb", [table]);
  assert.equal(scanned.info.materialCount, 1);
  assert.equal(scanned.figures.source.elements, 2);

  const walnut = join(process.env.ROSEAU_DATA || join(process.cwd(), "..", "shared"), "data/mtg_walnut/noylum2.mtg");
  if (existsSync(walnut)) {
    const read = await validate("walnut.glb", [walnut]);
    assert.equal(read.figures.source.placed_elements, 8301);
  } else {
    console.log(`the digitised walnut is absent: ${walnut} (set ROSEAU_DATA to where it is)`);
  }

  const refused = (args, status, words) => {
    const ran = spawnSync(program, ["tree", ...args], { encoding: "utf8" });
    assert.equal(ran.status, status, ran.stderr);
    assert.match(ran.stderr, words);
  };
  refused([], 2, /Exactly 1 option/);
  refused([table, "--grow"], 2, /Exactly 1 option/);
  refused(["--grow", "--simplify", "1"], 2, /simplify/);
  refused([join(folder, "absent.mtg")], 1, /absent\.mtg: is no file/);
  refused(["--grow", "--gltf", join(folder, "absent", "x.glb")], 1, /x\.glb\.part: cannot be written/);
} finally {
  rmSync(folder, { recursive: true });
}
console.log("ok");
