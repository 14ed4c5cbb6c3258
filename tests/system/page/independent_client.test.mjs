// A client that is not ours (@foxglove/ws-protocol) finds the live view, subscribes under both names of the protocol and
// decodes wind and pictures with the advertised schemas alone.
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { createFileRegistry, fromBinary } from "@bufbuild/protobuf";
import { FileDescriptorSetSchema } from "@bufbuild/protobuf/wkt";
import foxglove from "@foxglove/ws-protocol";
import WebSocket from "ws";
import { Demo } from "./demo.mjs";

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

/** Width and height in a JPEG's start-of-frame segment. */
function jpegSize(data) {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  for (let at = 2; at + 9 < view.byteLength; at += 2 + view.getUint16(at + 2)) {
    const marker = view.getUint16(at);
    if (marker >= 0xffc0 && marker <= 0xffc2) return { width: view.getUint16(at + 7), height: view.getUint16(at + 5) };
  }
  return undefined;
}
