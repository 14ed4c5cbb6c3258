// Which single flipped bits are noticed, by kind of record: by `roseau verify` (every bit), and by an independent reader with
// its CRC checks on (every bit with ROSEAU_ALL_BITS=1, else one bit of each byte). Prints the table of docs/sessions.md.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";

const decompressHandlers = await loadDecompressHandlers();
const ALL_BITS = process.env.ROSEAU_ALL_BITS === "1";
const MESSAGES = 9;

const inMemory = (bytes) => ({
  size: async () => BigInt(bytes.length),
  read: async (offset, length) => {
    if (Number(offset + length) > bytes.length) throw new Error("read beyond the end");
    return bytes.subarray(Number(offset), Number(offset + length));
  },
});

// Everything an indexed reader can read: messages, attachments, metadata. Throws, or says how many messages there are.
async function readIndexed(bytes) {
  const reader = await McapIndexedReader.Initialize({ readable: inMemory(bytes), decompressHandlers });
  let messages = 0;
  for await (const _ of reader.readMessages({ validateCrcs: true })) ++messages;
  for await (const _ of reader.readAttachments({ validateCrcs: true })) ++messages;
  for await (const _ of reader.readMetadata()) ++messages;
  return messages;
}

function readStreamed(bytes) {
  const reader = new McapStreamReader({ validateCrcs: true, decompressHandlers });
  reader.append(bytes);
  let records = 0;
  for (let record; (record = reader.nextRecord()); ) records += record.type === "Message" ? 1 : 0;
  return reader.done() ? records : -1;
}

async function isNoticed(read, bytes, expected) {
  try {
    return (await read(bytes)) !== expected;
  } catch {
    return true;
  }
}

async function judgeRegion(region, file, expected) {
  const counts = { tried: 0, indexed: 0, streamed: 0 };
  for (let at = region.begin; at < region.end; ++at) {
    for (let bit = 0; bit < 8; ++bit) {
      if (!ALL_BITS && bit !== at % 8) continue;
      const damaged = file.slice();
      damaged[at] ^= 1 << bit;
      ++counts.tried;
      counts.indexed += (await isNoticed(readIndexed, damaged, expected.indexed)) ? 1 : 0;
      counts.streamed += (await isNoticed(async (b) => readStreamed(b), damaged, expected.streamed)) ? 1 : 0;
    }
  }
  return counts;
}

const percent = (part, whole) => `${Math.floor((100 * part) / whole)} %`;

async function main() {
  const directory = mkdtempSync(join(tmpdir(), "roseau-bit-flips-"));
  try {
    const program = join(process.env.ROSEAU_BIN ?? "build/bin", "bit_flips");
    const path = join(directory, "every_record.mcap");
    execFileSync(program, ["write", path]);
    execFileSync(program, ["judge", join(directory, "ours.json")]);
    const file = new Uint8Array(readFileSync(path));
    const ours = JSON.parse(readFileSync(join(directory, "ours.json"), "utf8"));

    // Whole, both ways, with zstd and lz4.
    const expected = { indexed: await readIndexed(file), streamed: readStreamed(file) };
    assert.equal(expected.streamed, MESSAGES);
    assert.equal(expected.indexed, MESSAGES + 1 + 2);

    const rows = new Map();
    for (const region of ours) {
      const bits = 8 * (region.end - region.begin);
      assert.equal(region.noticed, bits, `${region.name}: verify misses ${bits - region.noticed} of ${bits} bits`);
      const theirs = await judgeRegion(region, file, expected);
      const row = rows.get(region.name) ?? { bits: 0, noticed: 0, tried: 0, indexed: 0, streamed: 0 };
      row.bits += bits;
      row.noticed += region.noticed;
      for (const key of Object.keys(theirs)) row[key] += theirs[key];
      rows.set(region.name, row);
    }
    console.log("| record | bits | roseau verify | @mcap/core, indexed | @mcap/core, streamed |\n|---|---|---|---|---|");
    const total = { bits: 0, noticed: 0, tried: 0, indexed: 0, streamed: 0 };
    for (const [name, row] of [...rows, ["all", total]]) {
      if (row !== total) for (const key of Object.keys(total)) total[key] += row[key];
      console.log(
        `| ${name} | ${row.bits} | ${percent(row.noticed, row.bits)} | ${percent(row.indexed, row.tried)} | ${percent(row.streamed, row.tried)} |`,
      );
    }
    // The judge is one: what stands in chunks it does notice (a bit that zstd has no use for may change unseen).
    for (const compression of ["stored", "zstd", "lz4"]) {
      const row = rows.get(`chunk, its records (${compression})`);
      assert.ok(row.indexed >= 0.98 * row.tried, compression);
    }
  } finally {
    rmSync(directory, { recursive: true, force: true });
  }
}

await main();
