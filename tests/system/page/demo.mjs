// Starting build/bin/display_demo (or any program that prints its address first) and ending it.
import { spawn } from "node:child_process";
import { existsSync } from "node:fs";
import { join } from "node:path";

const kBin = process.env.ROSEAU_BIN ?? "build/bin";

export class Demo {
  /** On a free port unless one is given. */
  static async start(args = [], port = 0) {
    const program = join(kBin, "display_demo");
    if (!existsSync(program)) throw new Error(`${program} is not there: build the target display_demo`);
    const child = spawn(program, ["--port", String(port), "--for", "900", ...args], { stdio: ["ignore", "pipe", "inherit"] });
    const url = await new Promise((resolve, reject) => {
      child.stdout.once("data", (data) => resolve(String(data).trim()));
      child.once("exit", (code) => reject(new Error(`display_demo ended at once (${code})`)));
    });
    return new Demo(child, url);
  }

  constructor(child, url) {
    this.child = child;
    this.url = url;
    this.port = Number(new URL(url).port);
  }

  async stop(signal = "SIGTERM") {
    if (this.child.exitCode !== null || this.child.signalCode !== null) return;
    const ended = new Promise((resolve) => this.child.once("exit", resolve));
    this.child.kill(signal);
    this.thaw(); // a frozen process ends only when it runs again
    await ended;
  }

  /** Stopped in its tracks, as a pulled network cable looks from outside. */
  freeze() {
    this.child.kill("SIGSTOP");
  }
  thaw() {
    this.child.kill("SIGCONT");
  }
}
