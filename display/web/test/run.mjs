// Bundles the page's unit tests, so that Node 18 can run TypeScript, and runs them.
import { spawnSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = mkdtempSync(join(tmpdir(), "roseau-page-tests-"));
function run(args) {
  return spawnSync(process.execPath, args, { stdio: "inherit" }).status ?? 1;
}
let status = run([join(here, "..", "build.mjs"), out, "--tests"]);
if (status === 0) {
  const tests = readdirSync(out).filter((name) => name.endsWith(".test.mjs"));
  status = tests.length === 0 ? 1 : run(["--test", ...tests.map((name) => join(out, name))]);
}
rmSync(out, { recursive: true });
process.exit(status);
