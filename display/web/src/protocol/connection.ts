// One lasting connection to the daemon: connects, notices when it goes silent, and comes back by itself.
import {
  kSubprotocols,
  parseBinary,
  parseText,
  subscribeText,
  unsubscribeText,
  type Channel,
  type ServerInfo,
} from "./codec.ts";

export interface ConnectionEvents {
  onServerInfo(info: ServerInfo): void;
  onChannels(channels: Channel[]): void;
  onMessage(channelId: number, logTime_ns: bigint, payload: Uint8Array): void;
  onStatus(level: number, message: string): void;
  onLink(connected: boolean): void;
}

// The server says something four times a second (/display/state): this long without a word, and it is said to be lost.
const kSilence_ms = 1300;
// A short hole in the radio link passes; after this long the connection is given up for a new one.
const kGiveUp_ms = 4000;
const kRetry_ms = 700;
const kLook_ms = 100;

export class Connection {
  private socket: WebSocket | undefined;
  private lastHeard_ms = 0;
  private retryAt_ms = 0;
  private connected = false;
  private nextSubscription = 1;
  private readonly channelOf = new Map<number, number>(); // by subscription
  private readonly subscriptionOf = new Map<number, number>(); // by channel

  constructor(
    private readonly url: string,
    private readonly events: ConnectionEvents,
  ) {}

  start(): void {
    this.open();
    setInterval(() => this.look(), kLook_ms);
  }

  subscribe(channelIds: number[]): void {
    const fresh = channelIds.filter((id) => !this.subscriptionOf.has(id));
    if (fresh.length === 0) return;
    const subscriptions = fresh.map((channelId) => {
      const id = this.nextSubscription++;
      this.subscriptionOf.set(channelId, id);
      this.channelOf.set(id, channelId);
      return { id, channelId };
    });
    this.send(subscribeText(subscriptions));
  }

  unsubscribe(channelId: number): void {
    const id = this.subscriptionOf.get(channelId);
    if (id === undefined) return;
    this.subscriptionOf.delete(channelId);
    this.channelOf.delete(id);
    this.send(unsubscribeText([id]));
  }

  private send(text: string): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(text);
  }

  private open(): void {
    const socket = new WebSocket(this.url, kSubprotocols);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.lastHeard_ms = performance.now();
    this.channelOf.clear();
    this.subscriptionOf.clear();
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      if (socket !== this.socket) return;
      this.heard();
      if (typeof event.data === "string") this.onText(event.data);
      else this.onBinary(event.data);
    };
    socket.onclose = () => {
      if (socket === this.socket) this.lose();
    };
  }

  private heard(): void {
    this.lastHeard_ms = performance.now();
    this.say(true);
  }

  private say(connected: boolean): void {
    if (this.connected === connected) return;
    this.connected = connected;
    this.events.onLink(connected);
  }

  private lose(): void {
    this.socket = undefined;
    this.retryAt_ms = performance.now() + kRetry_ms;
    this.say(false);
  }

  private look(): void {
    const now_ms = performance.now();
    const silent_ms = now_ms - this.lastHeard_ms;
    if (this.socket === undefined) {
      if (now_ms >= this.retryAt_ms) this.open();
    } else if (silent_ms > kGiveUp_ms) {
      // A pulled cable closes nothing: let go of this connection and try a new one.
      const silent = this.socket;
      this.lose();
      silent.close();
    } else if (silent_ms > kSilence_ms) {
      this.say(false);
    }
  }

  private onText(text: string): void {
    const message = parseText(text);
    if (message.op === "serverInfo") this.events.onServerInfo(message);
    if (message.op === "advertise") this.events.onChannels(message.channels);
    if (message.op === "status") this.events.onStatus(message.level, message.message);
  }

  private onBinary(data: ArrayBuffer): void {
    const message = parseBinary(data);
    if (message.kind !== "message") return;
    const channel = this.channelOf.get(message.subscription);
    if (channel !== undefined) this.events.onMessage(channel, message.logTime_ns, message.payload);
  }
}
