// A client that is not ours (@foxglove/ws-protocol) finds the live view, subscribes under both names of the protocol and
// decodes wind and pictures with the advertised schemas alone.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { createFileRegistry, fromBinary } from "@bufbuild/protobuf";
import { FileDescriptorSetSchema } from "@bufbuild/protobuf/wkt";
import foxglove from "@foxglove/ws-protocol";
import WebSocket from "ws";
import { Demo } from "./demo.mjs";
import { Replayed } from "./replayed.mjs";

const { FoxgloveClient } = foxglove;
let demo;
before(async () => {
  demo = await Demo.start();
});
after(() => demo.stop());

function decoder(channel) {
  assert.equal(channel.encoding, "protobuf");
  const files = fromBinary(FileDescriptorSetSchema, Buffer.from(channel.schema, "base64"));
  const type = createFileRegistry(files).getMessage(channel.schemaName);
  assert.ok(type, `the schema of ${channel.topic} holds ${channel.schemaName}`);
  return (data) => fromBinary(type, new Uint8Array(data.buffer, data.byteOffset, data.byteLength));
}

/** The first `count` messages of each topic, decoded. */
function collect(subprotocol, topics, count) {
  return new Promise((resolve, reject) => {
    const socket = new WebSocket(demo.url.replace("http", "ws"), [subprotocol]);
    const client = new FoxgloveClient({ ws: socket });
    const found = new Map();
    const byId = new Map();
    client.on("error", reject);
    client.on("advertise", (channels) => {
      for (const channel of channels) {
        if (!topics.includes(channel.topic)) continue;
        byId.set(client.subscribe(channel.id), { topic: channel.topic, decode: decoder(channel) });
        found.set(channel.topic, []);
      }
    });
    client.on("message", (event) => {
      const { topic, decode } = byId.get(event.subscriptionId);
      found.get(topic).push({ time: event.timestamp, message: decode(event.data) });
      if (topics.every((one) => (found.get(one)?.length ?? 0) >= count)) {
        client.close();
        resolve({ found, subprotocol: socket.protocol });
      }
    });
    setTimeout(() => reject(new Error(`no ${count} messages of each of ${topics} within 20 s`)), 20_000).unref();
  });
}

for (const name of ["foxglove.sdk.v1", "foxglove.websocket.v1"]) {
  test(`wind and pictures under ${name}`, async () => {
    const topics = ["/sonic/wind", "/camera0/image", "/camera0/image/preview", "/camera0/motion"];
    const { found, subprotocol } = await collect(name, topics, 3);
    assert.equal(subprotocol, name);

    const winds = found.get("/sonic/wind");
    for (const { message } of winds) {
      assert.equal(message.$typeName, "roseau.Wind");
      assert.ok(Math.hypot(message.uMps, message.vMps) > 0.5 && message.valid);
    }
    assert.ok(winds[1].time > winds[0].time, "log times rise");

    const raw = found.get("/camera0/image")[0].message;
    assert.equal(raw.$typeName, "foxglove.RawImage");
    assert.deepEqual([raw.width, raw.height, raw.step, raw.encoding], [1280, 1024, 1280, "mono8"]);
    assert.equal(raw.data.length, 1280 * 1024);
    assert.ok(new Set(raw.data.subarray(0, 5000)).size > 10, "the picture has content");

    const small = found.get("/camera0/image/preview")[0].message;
    assert.equal(small.format, "jpeg");
    assert.deepEqual([...small.data.subarray(0, 3)], [0xff, 0xd8, 0xff]);
    assert.deepEqual(jpegSize(small.data), { width: 960, height: 768 });

    const motion = found.get("/camera0/motion")[0].message;
    assert.ok(motion.points.some((one) => one.metadata.some((entry) => entry.value === "branch")));
  });
}

test("a foreign subprotocol is refused with 400", async () => {
  const status = await new Promise((resolve) => {
    const socket = new WebSocket(demo.url.replace("http", "ws"), ["mqtt"]);
    socket.on("unexpected-response", (_request, response) => {
      resolve(response.statusCode);
      socket.terminate();
    });
    socket.on("error", () => {});
  });
  assert.equal(status, 400);
});

// --- a replay, driven by a viewer. The client's newest version knows nothing of playback: these messages are written and read
// here by hand.

function playbackControl({ play, speed, seek_ns, id }) {
  const text = Buffer.from(id);
  const bytes = Buffer.alloc(19 + text.length);
  bytes.writeUInt8(0x03, 0);
  bytes.writeUInt8(play ? 0 : 1, 1);
  bytes.writeFloatLE(speed, 2);
  bytes.writeUInt8(seek_ns === undefined ? 0 : 1, 6);
  bytes.writeBigUInt64LE(seek_ns ?? 0n, 7);
  bytes.writeUInt32LE(text.length, 15);
  text.copy(bytes, 19);
  return bytes;
}

function readPlaybackState(bytes) {
  assert.equal(bytes.length, 19 + bytes.readUInt32LE(15));
  return {
    status: ["playing", "paused", "buffering", "ended"][bytes.readUInt8(1)],
    time_ns: bytes.readBigUInt64LE(2),
    speed: bytes.readFloatLE(10),
    didSeek: bytes.readUInt8(14) === 1,
    id: bytes.subarray(19).toString(),
  };
}

/** A viewer of a replay: what came, in its order, and a way to wait for something among what came. */
class ReplayViewer {
  static async open(url, subprotocol, topics) {
    const viewer = new ReplayViewer(url, subprotocol, topics);
    await viewer.until(() => viewer.info !== undefined && topics.every((topic) => viewer.found.some((one) => one.topic === topic)));
    return viewer;
  }

  constructor(url, subprotocol, topics) {
    this.found = []; // { topic, time, message }, { playback }, { time_ns }, { status }
    this.socket = new WebSocket(url.replace("http", "ws"), [subprotocol]);
    this.client = new FoxgloveClient({ ws: this.socket });
    this.byId = new Map();
    this.client.on("serverInfo", (info) => (this.info = info));
    this.client.on("time", ({ timestamp }) => this.found.push({ time_ns: timestamp }));
    this.client.on("status", (status) => this.found.push({ status }));
    this.client.on("error", () => {}); // opcode 5 is new to it
    this.client.on("advertise", (channels) => {
      for (const channel of channels.filter(({ topic }) => topics.includes(topic))) {
        this.byId.set(this.client.subscribe(channel.id), { topic: channel.topic, decode: decoder(channel) });
      }
    });
    this.client.on("message", (event) => {
      const { topic, decode } = this.byId.get(event.subscriptionId);
      this.found.push({ topic, time_ns: event.timestamp, message: decode(event.data) });
    });
    this.socket.addEventListener("message", ({ data }) => {
      if (typeof data === "string") return;
      const bytes = Buffer.from(data);
      if (bytes[0] === 0x05) this.found.push({ playback: readPlaybackState(bytes) });
    });
  }

  async until(condition) {
    const patience = Date.now() + 20_000;
    for (;;) {
      const result = condition();
      if (result) return result;
      if (Date.now() > patience) throw new Error(`nothing like ${condition}`);
      await new Promise((resolve) => setTimeout(resolve, 10));
    }
  }

  /** Asks; what came after the answer is in `found` then. */
  async ask(request) {
    this.socket.send(playbackControl(request));
    const answer = await this.until(() => this.found.find((one) => one.playback?.id === request.id));
    this.found = this.found.slice(this.found.indexOf(answer) + 1);
    return answer.playback;
  }
}

for (const name of ["foxglove.sdk.v1", "foxglove.websocket.v1"]) {
  test(`a viewer drives a replay under ${name}`, async (t) => {
    const replayed = await Replayed.start(6);
    t.after(() => replayed.stop());
    const topics = ["/camera0/image", "/sonic/wind"];
    const viewer = await ReplayViewer.open(replayed.url, name, topics);
    t.after(() => viewer.client.close());

    assert.ok(viewer.info.capabilities.includes("time") && viewer.info.capabilities.includes("playbackControl"));
    const instant = ({ sec, nsec }) => BigInt(sec) * 1_000_000_000n + BigInt(nsec);
    const begin_ns = instant(viewer.info.dataStartTime);
    const end_ns = instant(viewer.info.dataEndTime);
    assert.ok(end_ns - begin_ns > 5_900_000_000n && end_ns - begin_ns < 6_500_000_000n);
    const knows = () => viewer.found.some((one) => one.playback?.id === "");
    assert.equal(knows(), name === "foxglove.sdk.v1", "the older name is told nothing that it may not know");

    // Paused: the frame at or just before the place, and nothing after it.
    const place_ns = begin_ns + 4_000_000_000n;
    const paused = await viewer.ask({ play: false, speed: 1, seek_ns: place_ns, id: "first" });
    assert.deepEqual(paused, { status: "paused", time_ns: place_ns, speed: 1, didSeek: true, id: "first" });
    await viewer.until(() => viewer.found.some((one) => one.topic === "/camera0/image"));
    await new Promise((resolve) => setTimeout(resolve, 500));
    const sampleTime = ({ message }) => message.timestamp.seconds * 1_000_000_000n + BigInt(message.timestamp.nanos);
    const shown = viewer.found.filter((one) => one.topic === "/camera0/image").map(sampleTime);
    assert.ok(shown.every((time_ns) => time_ns <= place_ns), "nothing later than the place");
    assert.ok(place_ns - shown.at(-1) < 34_000_000n, "the last frame before it");
    assert.ok(viewer.found.some((one) => one.topic === "/sonic/wind"), "with the latest values");
    assert.ok(viewer.found.every((one) => one.topic === undefined || one.time_ns <= place_ns + 100_000_000n));
    assert.ok(viewer.found.filter((one) => one.topic === undefined && one.time_ns !== undefined).every((one) => one.time_ns === place_ns));

    // Playing, faster, from the place before: time goes on from there.
    const played = await viewer.ask({ play: true, speed: 2, seek_ns: begin_ns + 1_000_000_000n, id: "second" });
    assert.equal(played.status, "playing");
    assert.equal(played.speed, 2);
    await viewer.until(() => viewer.found.some((one) => one.topic === "/sonic/wind" && one.time_ns > begin_ns + 2_000_000_000n));
    const winds = viewer.found.filter((one) => one.topic === "/sonic/wind").map((one) => one.time_ns);
    assert.ok(winds[0] <= begin_ns + 1_000_000_000n, "nothing of the place before after the answer");
    assert.ok(winds.every((time_ns, i) => i === 0 || time_ns >= winds[i - 1]));

    // What makes no sense is answered with words, and the replay goes on.
    viewer.socket.send(Buffer.from([0x03, 0, 0]));
    viewer.socket.send(playbackControl({ play: true, speed: -1, id: "wrong" }));
    await viewer.until(() => viewer.found.filter((one) => one.status?.level === 2).length === 2);

    // At the end it waits, because somebody watches, and can be sought again.
    await viewer.ask({ play: true, speed: 1, seek_ns: end_ns + 5_000_000_000n, id: "end" });
    const ended = await viewer.until(() => viewer.found.find((one) => one.playback?.status === "ended"));
    assert.equal(ended.playback.time_ns, end_ns);
    const again = await viewer.ask({ play: true, speed: 1, id: "again" });
    assert.equal(again.status, "playing");
    assert.equal(again.didSeek, true, "playing from the end is playing from the begin");
  });
}

test("what follows a seek to the begin has the digest of a fresh replay", async (t) => {
  const fresh = await Replayed.start(4, ["--max"]);
  await fresh.ended;
  const { digest } = await fresh.stop();
  const sought = await Replayed.start(4);
  t.after(() => sought.stop());
  await new Promise((resolve) => setTimeout(resolve, 700));
  for (const time_s of [3, 1, 2.5, 0]) await sought.ask({ command: "seek", time_s });
  await sought.ask({ command: "speed", speed: null });
  await sought.ended;
  assert.equal((await sought.stop()).digest, digest);
});

/** Width and height in a JPEG's start-of-frame segment. */
function jpegSize(data) {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  for (let at = 2; at + 9 < view.byteLength; at += 2 + view.getUint16(at + 2)) {
    const marker = view.getUint16(at);
    if (marker >= 0xffc0 && marker <= 0xffc2) return { width: view.getUint16(at + 7), height: view.getUint16(at + 5) };
  }
  return undefined;
}
