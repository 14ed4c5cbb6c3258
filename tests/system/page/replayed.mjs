// The real program replaying a short session that it has simulated itself.
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const kProgram = join(process.env.ROSEAU_BIN ?? "build/bin", "roseau");
// Small pictures, so that it is quick.
const kCamera = "[[camera]]\nwidth_px = 320\nheight_px = 240\nfocal_length_px = 400\n";

export class Replayed {
  /** `args`: further ones of `roseau replay`. */
  static async start(seconds, args = []) {
    if (!existsSync(kProgram)) throw new Error(`${kProgram} is not there: build the target roseau`);
    const folder = mkdtempSync(join(tmpdir(), "roseau-replayed-"));
    writeFileSync(join(folder, "scene.toml"), kCamera + kCamera);
    const file = join(folder, "session.mcap");
    const made = spawnSync(kProgram, ["simulate", join(folder, "scene.toml"), "-o", file, "--seconds", String(seconds), "--seed", "7"]);
    if (made.status !== 0) throw new Error(`roseau simulate: ${made.stderr}`);
    const child = spawn(kProgram, ["replay", file, "--port", "0", "--json", ...args], { stdio: ["ignore", "pipe", "pipe"] });
    const replayed = new Replayed(child, folder);
    replayed.url = await new Promise((resolve, reject) => {
      child.stderr.on("data", (data) => {
        replayed.said += data;
        const found = /live page: (http:\/\/\S+)/.exec(replayed.said);
        if (found !== null) resolve(found[1]);
      });
      child.once("exit", (code) => reject(new Error(`roseau replay ended at once (${code}): ${replayed.said}`)));
    });
    return replayed;
  }

  constructor(child, folder) {
    this.child = child;
    this.folder = folder;
    this.said = "";
    this.out = "";
    child.stdout.on("data", (data) => (this.out += data));
    this.ended = new Promise((resolve) => child.once("close", resolve));
  }

  async ask(command) {
    const headers = { "Content-Type": "application/json" };
    const response = await fetch(`${this.url}/api/player`, { method: "POST", headers, body: JSON.stringify(command) });
    if (!response.ok) throw new Error(await response.text());
  }

  async player() {
    return (await (await fetch(`${this.url}/api/state`)).json()).player;
  }

  /** Ends it; its summary. */
  async stop() {
    if (this.child.exitCode === null) this.child.kill("SIGINT");
    await this.ended;
    rmSync(this.folder, { recursive: true, force: true });
    return this.out === "" ? undefined : JSON.parse(this.out);
  }
}
