// Notices: short words at the foot of the page (what was done, what could not be), and the banner when the daemon is lost.
import type { Feed } from "../model/feed.ts";
import { roughDuration } from "../model/format.ts";
import { byId, h, setHidden, setText } from "./dom.ts";

const kShown_ms = 5000;

export class Notices {
  private readonly list = byId("notices");
  private readonly banner = byId("banner");
  private readonly bannerText = byId("banner-text");

  say(text: string, kind: "ok" | "bad" = "ok"): void {
    const sign = kind === "ok" ? "✓" : "✕";
    const notice = h("div", `notice ${kind}`, h("span", "sign", sign), h("span", "", text));
    this.list.append(notice);
    while (this.list.children.length > 3) this.list.firstElementChild?.remove();
    setTimeout(() => notice.remove(), kind === "ok" ? kShown_ms : 2 * kShown_ms);
  }

  /** For the answer of an action: says `done` when there is no error. */
  report(error: string | undefined, done: string): void {
    this.say(error ?? done, error === undefined ? "ok" : "bad");
  }

  update(feed: Feed): void {
    setHidden(this.banner, feed.connected);
    document.body.classList.toggle("lost", !feed.connected);
    if (feed.connected) return;
    const since_s = (performance.now() - feed.lostAt_ms) / 1000;
    const never = feed.info === undefined;
    setText(
      this.bannerText,
      never
        ? "Looking for the daemon. If this stays: is roseau running?"
        : `Daemon lost for ${roughDuration(since_s)}. Nothing below is live. Is roseau running, is the network up? This page comes back by itself.`,
    );
  }
}
