// The page: joins the session's data with the views and updates them ten times a second; pictures draw as they come.
import { Feed } from "./model/feed.ts";
import { Session } from "./model/session.ts";
import { CameraTile } from "./view/camera_tile.ts";
import { Charts } from "./view/charts.ts";
import { byId, setClass, setHidden } from "./view/dom.ts";
import { HealthChips } from "./view/health_chips.ts";
import { listenForKeys } from "./view/keys.ts";
import { Notices } from "./view/notices.ts";
import { PlayerBar } from "./view/player_bar.ts";
import { TargetPanel } from "./view/target_panel.ts";
import { Theme } from "./view/theme.ts";
import { Timeline } from "./view/timeline.ts";
import { TopBar } from "./view/top_bar.ts";
import { WindPanel } from "./view/wind_panel.ts";

const kWords_ms = 100;
const kCharts_ms = 90;

const session = new Session();
const feed = new Feed(session, `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/`);
const theme = new Theme();
const timeline = new Timeline();
const notices = new Notices();
const tiles = new Map<string, CameraTile>();
const targets = new TargetPanel(session, tiles, notices);
const topBar = new TopBar(session, feed, notices);
const chips = new HealthChips(session);
const wind = new WindPanel(session);
const charts = new Charts(session, timeline);
const player = new PlayerBar(session, feed, notices);
const chooseButton = byId("choose");
let choosing = false;

function isPaused(): boolean {
  const state = session.state?.player;
  return state != null && (!state.playing || state.ended);
}

function choose(on: boolean): void {
  choosing = on;
  setClass(chooseButton, "on", on);
  chooseButton.setAttribute("aria-pressed", String(on));
  for (const tile of tiles.values()) {
    tile.arm(on);
    if (!on) tile.cancel();
  }
}

/** A tile for every camera there is now, none for those that are gone. */
function updateTiles(): void {
  const place = byId("cameras");
  for (const [device, camera] of session.cameras) {
    if (tiles.has(device)) continue;
    const tile = new CameraTile(camera, {
      notices,
      freeName: () => targets.freeName(),
      selected: () => (targets.selected?.device === device ? targets.selected.name : undefined),
      mayChoose: () => !session.isReplay,
      onDrawn: () => {
        if (targets.selected?.device === device) targets.drawCloseUp();
      },
    });
    tiles.set(device, tile);
    place.append(tile.element);
  }
  for (const [device, tile] of tiles) {
    if (session.cameras.has(device)) continue;
    tile.element.remove();
    tiles.delete(device);
  }
  place.dataset["count"] = String(tiles.size);
  setHidden(byId("no-cameras"), tiles.size > 0);
  setHidden(chooseButton, session.isReplay);
  for (const tile of tiles.values()) tile.update(isPaused());
}

function updateWords(): void {
  updateTiles();
  topBar.update();
  chips.update(feed.connected);
  targets.update();
  wind.update(targets.selected, targets.estimating, isPaused());
  player.update();
  notices.update(feed);
}

function selectByNumber(number: number): void {
  targets.select(targets.targets()[number - 1]);
}

/** What is replayed has happened: its keys do nothing. */
function live(action: () => void): () => void {
  return () => {
    if (!session.isReplay) action();
  };
}

const keys = new Map<string, () => void>([
  ["m", live(() => void topBar.mark())],
  ["r", live(() => void topBar.record())],
  ["g", live(() => void topBar.trigger())],
  ["t", live(() => choose(!choosing))],
  ["l", () => theme.toggle()],
  ["f", () => [...tiles.values()][0]?.toggleFull()],
  [" ", () => player.toggle()],
  ["arrowleft", () => player.step(-1)],
  ["arrowright", () => player.step(+1)],
  [
    "escape",
    () => {
      choose(false);
      chips.close();
    },
  ],
]);
for (let number = 1; number <= 9; ++number) keys.set(String(number), () => selectByNumber(number));

byId("theme").addEventListener("click", () => theme.toggle());
chooseButton.addEventListener("click", () => choose(!choosing));
theme.onChange = () => charts.redraw();
targets.onSelect = () => charts.reset();
session.onReset = () => {
  charts.reset();
  timeline.release();
};
feed.onStatus = (level, message) => notices.say(message, level === 0 ? "ok" : "bad");
document.addEventListener("visibilitychange", () => feed.watchPictures(!document.hidden));
listenForKeys(keys);

let chartsAt_ms = 0;
function onFrame(now_ms: number): void {
  requestAnimationFrame(onFrame);
  timeline.follow(session.newest_s);
  if (now_ms - chartsAt_ms < kCharts_ms) return;
  chartsAt_ms = now_ms;
  charts.update(targets.selected, targets.estimating);
}

feed.start();
setInterval(updateWords, kWords_ms);
requestAnimationFrame(onFrame);
