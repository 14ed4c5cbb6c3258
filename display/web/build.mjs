// Builds the page: node display/web/build.mjs OUT_DIR [--tests]
// --tests: bundles test/*.test.ts instead, so that Node 18 can run them.
import { copyFileSync, mkdirSync, readdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];
if (out === undefined) {
  console.error("usage: node display/web/build.mjs OUT_DIR [--tests]");
  process.exit(2);
}
mkdirSync(out, { recursive: true });

if (process.argv.includes("--tests")) {
  const tests = readdirSync(join(here, "test")).filter((name) => name.endsWith(".test.ts"));
  await build({
    entryPoints: tests.map((name) => join(here, "test", name)),
    bundle: true,
    platform: "node",
    format: "esm",
    outExtension: { ".js": ".mjs" },
    outdir: out,
    logLevel: "warning",
  });
} else {
  await build({
    entryPoints: { page: join(here, "src/main.ts") },
    bundle: true,
    minify: true,
    sourcemap: true,
    format: "esm",
    target: ["es2022"],
    outdir: out,
    logLevel: "warning",
  });
  await build({
    entryPoints: { page: join(here, "style/page.css") },
    bundle: true,
    minify: true,
    outdir: out,
    logLevel: "warning",
  });
  for (const name of ["index.html", "favicon.svg"]) copyFileSync(join(here, name), join(out, name));
}
