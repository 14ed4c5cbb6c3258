// A decoder per channel, made from the schema the server advertised: the page carries no message definitions of its own.
import { createFileRegistry, fromBinary, type DescMessage } from "@bufbuild/protobuf";
import { FileDescriptorSetSchema } from "@bufbuild/protobuf/wkt";
import { bytesFromBase64, type Channel } from "./codec.ts";

export type Decode = (payload: Uint8Array) => unknown;

// Channels of one kind share their schema: each is read once.
const known = new Map<string, DescMessage | undefined>();

function messageType(channel: Channel): DescMessage | undefined {
  const key = `${channel.schemaName}\n${channel.schema}`;
  if (!known.has(key)) {
    const files = fromBinary(FileDescriptorSetSchema, bytesFromBase64(channel.schema));
    known.set(key, createFileRegistry(files).getMessage(channel.schemaName));
  }
  return known.get(key);
}

/** Nothing when the page cannot read this channel (another encoding, a broken schema). */
export function decoderFor(channel: Channel): Decode | undefined {
  if (channel.encoding === "json") {
    const text = new TextDecoder();
    return (payload) => JSON.parse(text.decode(payload)) as unknown;
  }
  if (channel.encoding !== "protobuf" || channel.schemaEncoding !== "protobuf") return undefined;
  try {
    const type = messageType(channel);
    return type && ((payload) => fromBinary(type, payload));
  } catch {
    return undefined;
  }
}
