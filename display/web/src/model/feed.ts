// Feed: connects the session with the daemon. A channel's past is fetched before its live messages are let in.
import { Connection } from "../protocol/connection.ts";
import { parseBinary, type Channel, type ServerInfo } from "../protocol/codec.ts";
import { fetchHistory, fetchStreams } from "./api.ts";
import type { Session } from "./session.ts";

interface LiveMessage {
  resets: number; // of the session, when it came
  logTime_ns: bigint;
  payload: Uint8Array;
}

export class Feed {
  info: ServerInfo | undefined;
  connected = false;
  lostAt_ms = performance.now();
  onLink: ((connected: boolean) => void) | undefined;
  onStatus: ((level: number, message: string) => void) | undefined;

  private readonly connection: Connection;
  private readonly waiting = new Map<number, LiveMessage[]>(); // by channel, while its past is on its way
  private watchingPictures = true;

  constructor(
    private readonly session: Session,
    url: string,
  ) {
    this.connection = new Connection(url, {
      onServerInfo: (info) => this.onServerInfo(info),
      onChannels: (channels) => void this.onChannels(channels),
      onMessage: (channel, logTime_ns, payload) => this.onMessage(channel, logTime_ns, payload),
      onStatus: (level, message) => this.onStatus?.(level, message),
      onLink: (connected) => {
        this.connected = connected;
        this.lostAt_ms = performance.now();
        this.onLink?.(connected);
      },
    });
  }

  start(): void {
    this.connection.start();
  }

  /** Pictures cost the daemon and the network most: let go of them while the page is hidden. */
  watchPictures(watch: boolean): void {
    this.watchingPictures = watch;
    const channels = this.session.pictureChannels();
    if (watch) this.connection.subscribe(channels);
    else for (const channel of channels) this.connection.unsubscribe(channel);
  }

  private onServerInfo(info: ServerInfo): void {
    this.waiting.clear();
    if (this.info !== undefined && this.info.sessionId !== info.sessionId) this.session.forgetRun();
    this.info = info;
  }

  private async onChannels(channels: Channel[]): Promise<void> {
    let wanted: { subscribe: number[]; history: number[] };
    try {
      wanted = this.session.addChannels(channels, await fetchStreams());
    } catch {
      return; // lost again in between: the next connection starts over
    }
    for (const channel of wanted.history) this.waiting.set(channel, []);
    const pictures = this.watchingPictures ? [] : this.session.pictureChannels();
    this.connection.subscribe(wanted.subscribe.filter((channel) => !pictures.includes(channel)));
    await Promise.all(wanted.history.map((channel) => this.fetchPast(channel)));
  }

  private async fetchPast(channel: number): Promise<void> {
    const resets = this.session.resets; // should a replay jump meanwhile, this past is of another place
    try {
      for (const data of await fetchHistory(channel)) {
        const message = parseBinary(data);
        if (message.kind === "message" && resets === this.session.resets) {
          this.session.receive(channel, message.logTime_ns, message.payload);
        }
      }
    } catch {
      // Without its past the channel starts now.
    }
    const live = this.waiting.get(channel) ?? [];
    this.waiting.delete(channel);
    for (const message of live) {
      if (message.resets === this.session.resets) this.session.receive(channel, message.logTime_ns, message.payload);
    }
  }

  private onMessage(channel: number, logTime_ns: bigint, payload: Uint8Array): void {
    const waiting = this.waiting.get(channel);
    if (waiting !== undefined) waiting.push({ resets: this.session.resets, logTime_ns, payload });
    else this.session.receive(channel, logTime_ns, payload);
  }
}
