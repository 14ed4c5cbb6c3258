// The page in a real browser: it lives, it is legible, it says when the daemon is lost and comes back by itself.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { findChromium, openBrowser, openPage, waitForLife } from "./browser.mjs";
import { Demo } from "./demo.mjs";
import { Replayed } from "./replayed.mjs";

if (findChromium() === undefined) {
  console.log("skipped: no Chromium here (apt-get install chromium, or set CHROMIUM to its path)");
  process.exit(77);
}

const out = process.env.ROSEAU_TEST_OUT ?? "build/test-out";
mkdirSync(out, { recursive: true });
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

let demo;
let browser;
before(async () => {
  demo = await Demo.start();
  browser = await openBrowser();
});
after(async () => {
  await browser.close();
  await demo.stop();
});

/** A page that is closed when the test ends, however it ends. */
async function open(t, url, options) {
  const opened = await openPage(browser, url, options);
  t.after(() => opened.context.close());
  return opened;
}

async function startOwn(t, args, port) {
  const own = await Demo.start(args, port);
  t.after(() => own.stop());
  return own;
}

const text = (page, selector) => page.locator(selector).innerText();
const number = async (page, selector) => Number((await text(page, selector)).replace("−", "-"));

/** Share of a canvas' pixels that differ from its most frequent colour. */
async function ink(page, selector) {
  return page.locator(selector).first().evaluate((canvas) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    const counts = new Map();
    for (let i = 0; i < data.length; i += 4) {
      const key = (data[i] << 16) | (data[i + 1] << 8) | data[i + 2] | (data[i + 3] < 128 ? 1 << 24 : 0);
      counts.set(key, (counts.get(key) ?? 0) + 1);
    }
    return 1 - Math.max(...counts.values()) / (data.length / 4);
  });
}

/** Serious faults an automatic check of accessibility finds (contrast, names, roles). */
async function seriousFaults(page) {
  await page.evaluate(axe);
  const result = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  return result.violations
    .filter((fault) => fault.impact === "serious" || fault.impact === "critical")
    .map((fault) => `${fault.id}: ${fault.nodes.map((node) => `${node.target} ${node.any[0]?.message ?? ""}`).join("; ")}`);
}

/** Buttons smaller than a gloved finger. */
async function smallButtons(page) {
  return page.locator("button:visible").evaluateAll((buttons) =>
    buttons
      .map((button) => ({ name: button.textContent, box: button.getBoundingClientRect() }))
      .filter(({ box }) => box.width < 44 || box.height < 44)
      .map(({ name, box }) => `${name} ${box.width} x ${box.height}`),
  );
}

for (const theme of ["dark", "light"]) {
  test(`it lives, in ${theme}`, async (t) => {
    const { page, errors } = await open(t, demo.url, { theme });
    await waitForLife(page);
    await page.waitForFunction(() => /\d/.test(document.getElementById("estimate-value").textContent));
    await page.waitForFunction(() => document.getElementById("spectrum-empty").hidden);
    await page.waitForTimeout(1500);

    const speed = await number(page, "#wind-speed");
    assert.ok(speed > 0.5 && speed < 15, `wind ${speed}`);
    assert.match(await text(page, "#wind-from"), /^from 2\d\d°$/);
    assert.match(await text(page, "#estimate-value"), /^\d+\.\d ± \d\.\d$/);
    assert.equal(await text(page, "#estimate-title"), "Estimated from all targets");
    assert.match(await text(page, "#estimate-trust"), /explains 91 % of .* along 243°/);
    for (const name of ["camera0", "camera1", "sonic"]) {
      assert.match(await text(page, `.chip:has-text("${name}")`), new RegExp(`✓\\s*${name}\\s*[\\d.]+/s`));
    }
    for (const canvas of ["canvas.picture", "#close-up", "#wind-chart canvas", "#displacement-chart canvas", "#spectrum-chart canvas"]) {
      assert.ok((await ink(page, canvas)) > 0.01, `${canvas} is empty`);
    }
    assert.equal(await page.locator(".target-row").count(), 2);
    assert.deepEqual(await seriousFaults(page), []);
    assert.deepEqual(await smallButtons(page), []);
    await page.screenshot({ path: join(out, `page-${theme}.png`) });
    assert.deepEqual(errors, []);
  });
}

test("a target is selected by its number, and let go by the same", async (t) => {
  const { page } = await open(t, demo.url);
  await waitForLife(page);
  await page.waitForFunction(() => document.getElementById("estimate-title").textContent === "Estimated from all targets");
  await page.keyboard.press("2");
  await page.waitForFunction(() => document.getElementById("estimate-title").textContent === "Estimated from twig");
  assert.equal(await text(page, "#displacement-title"), "Displacement of twig");
  await page.keyboard.press("2");
  await page.waitForFunction(() => document.getElementById("estimate-title").textContent === "Estimated from all targets");
});

test("pictures move", async (t) => {
  const { page } = await open(t, demo.url);
  await waitForLife(page);
  const look = () => page.locator("canvas.picture").first().evaluate((canvas) => canvas.toDataURL());
  const first = await look();
  await page.waitForTimeout(400);
  assert.notEqual(await look(), first);
});

test("a phone's width needs no sideways scrolling", async (t) => {
  const { page, errors } = await open(t, demo.url, { width: 390, height: 844, theme: "light", touch: true });
  await waitForLife(page);
  await page.waitForTimeout(1000);
  const widths = await page.evaluate(() => [document.documentElement.scrollWidth, window.innerWidth]);
  assert.ok(widths[0] <= 390 && widths[1] <= 390, `the page is ${widths} wide`);
  assert.deepEqual(await smallButtons(page), []);
  assert.deepEqual(await seriousFaults(page), []);
  await page.screenshot({ path: join(out, "page-phone.png"), fullPage: true });
  assert.deepEqual(errors, []);
});

test("recording starts with one press and stops with two; marks show", async (t) => {
  const { page } = await open(t, demo.url);
  await waitForLife(page);
  await page.keyboard.press("r");
  await page.waitForFunction(() => document.getElementById("rec-state").dataset.state === "recording");
  assert.equal(await text(page, "#session-name"), "storm-03.mcap");
  await page.keyboard.press("m");
  await page.waitForSelector(".notice.ok:has-text('Marked')");
  await page.keyboard.press("r");
  await page.waitForSelector("#record.sure");
  assert.equal(await text(page, "#rec-word"), "REC", "one press does not stop it");
  await page.keyboard.press("r");
  await page.waitForFunction(() => document.getElementById("rec-state").dataset.state === "idle");
});

test("a target is chosen by drawing a rectangle", async (t) => {
  const { page } = await open(t, demo.url);
  await waitForLife(page);
  const asked = page.waitForRequest((request) => request.url().endsWith("/api/action"));
  const box = await page.locator("canvas.picture").first().boundingBox();
  await page.mouse.move(box.x + 0.25 * box.width, box.y + 0.5 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.4 * box.width, box.y + 0.6 * box.height);
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.75 * box.height);
  await page.mouse.up();
  await page.keyboard.type("crown");
  await page.keyboard.press("Enter");
  const action = (await asked).postDataJSON();
  assert.equal(action.kind, "add_target");
  assert.equal(action.camera, "camera0");
  assert.equal(action.text, "crown");
  // In the camera's 1280 x 1024 pixels, whatever the size of the picture on the page.
  for (const [name, expected] of Object.entries({ x: 320, y: 512, width: 320, height: 256 })) {
    assert.ok(Math.abs(action.region[name] - expected) < 8, `${name} ${action.region[name]}`);
  }
  await page.waitForSelector(".notice.ok:has-text('crown')");
});

test("time is zoomed, moved and brought back", async (t) => {
  const { page } = await open(t, demo.url);
  await waitForLife(page);
  const box = await page.locator("#wind-chart .u-over").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.wheel(0, -600);
  await page.waitForFunction(() => Number.parseFloat(document.getElementById("chart-span").textContent.slice(5)) < 40);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width, box.y + box.height / 2, { steps: 5 });
  await page.mouse.up();
  await page.waitForSelector("#back-to-now:visible");
  await page.mouse.dblclick(box.x + box.width / 2, box.y + box.height / 2);
  await page.waitForFunction(() => document.getElementById("chart-span").textContent === "last 60 s");
});

test("a page opened later shows the past at once", async (t) => {
  const { page } = await open(t, demo.url);
  await waitForLife(page);
  // Ten seconds have gone by in the tests before; without history the charts would start empty.
  await page.waitForTimeout(500);
  const share = await page.locator("#wind-chart canvas").evaluate((canvas) => {
    // Columns right of the axis in which a line was drawn in the colour of the measured series (blue).
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let columns = 0;
    for (let x = 0; x < canvas.width; ++x) {
      for (let y = 0; y < canvas.height; ++y) {
        const i = 4 * (y * canvas.width + x);
        if (data[i + 3] > 200 && data[i + 2] > data[i] + 80) {
          ++columns;
          break;
        }
      }
    }
    return columns / canvas.width;
  });
  assert.ok(share > 0.15, `only ${share} of the chart is drawn`);
});

test("a lost daemon is said within 2 s and the page comes back by itself", async (t) => {
  const own = await startOwn(t);
  const { page } = await open(t, own.url);
  await waitForLife(page);
  await own.stop("SIGKILL");
  await page.waitForSelector("#banner:visible", { timeout: 2000 });
  assert.match(await text(page, "#banner-text"), /Daemon lost/);
  await page.screenshot({ path: join(out, "page-lost.png") });
  const again = await startOwn(t, [], own.port);
  await page.waitForSelector("#banner", { state: "hidden", timeout: 5000 });
  await waitForLife(page);
  await page.waitForFunction(() => !document.getElementById("wind-measured").classList.contains("stale"));
  // Silent, not closed: a pulled cable.
  again.freeze();
  await page.waitForSelector("#banner:visible", { timeout: 4000 }); // 2 s, and slack for a busy machine
  again.thaw();
  await page.waitForSelector("#banner", { state: "hidden", timeout: 5000 });
});

test("trouble is told in words with its remedy", async (t) => {
  const own = await startOwn(t, ["--trouble"]);
  const { page, errors } = await open(t, own.url);
  await page.waitForSelector(".alert.bad:has-text('check its cable')", { timeout: 15_000 });
  assert.match(await text(page, ".chip:has-text('sonic')"), /reopening/);
  assert.match(await text(page, ".chip:has-text('camera1')"), /3 gaps/);
  await page.waitForSelector("#wind-measured.stale");
  assert.match(await text(page, "#wind-age"), /s old/);
  await page.waitForFunction(() => document.getElementById("estimate-reason").textContent.includes("lost from sight"));
  assert.equal(await text(page, "#estimate-value"), "–");
  await page.locator(".chip:has-text('camera1')").click();
  assert.match(await text(page, "#details"), /\/camera1\/image/);
  assert.match(await text(page, "#details"), /clock known to 80 µs/);
  assert.deepEqual(await seriousFaults(page), []);
  await page.screenshot({ path: join(out, "page-trouble.png") });
  assert.deepEqual(errors, []);
});

test("a trigger records what came before it, and says so", async (t) => {
  const own = await startOwn(t);
  const { page } = await open(t, own.url);
  await waitForLife(page);
  await page.waitForFunction(() => document.getElementById("rec-more").textContent === "keeps the last 10 s for a trigger");
  await page.keyboard.press("g");
  await page.waitForSelector(".notice.ok:has-text('recording from 10 s ago')");
  await page.waitForFunction(() => /by trigger gust, ends in \d+ s/.test(document.getElementById("rec-more").textContent));
  assert.equal(await text(page, "#rec-word"), "REC");
  assert.match(await text(page, "#rec-more"), /^part 3/);
  assert.equal(await text(page, "#disk"), "212 GB free = 5 h 10 min");
  assert.deepEqual(await seriousFaults(page), []);
});

test("a replay is sought by slider and keys, playing and paused", async (t) => {
  const replayed = await Replayed.start(8);
  t.after(() => replayed.stop());
  const { page, errors } = await open(t, replayed.url);
  await page.waitForSelector("#player:visible");
  await waitForLife(page);
  const position_s = async () => {
    const [, minutes, seconds] = /(\d\d):(\d\d) of/.exec(await text(page, "#player-position"));
    return 60 * Number(minutes) + Number(seconds);
  };
  const picture = () => page.locator("canvas.picture").first().evaluate((canvas) => canvas.toDataURL());
  // Charts: the newest second on the axis and how much of it is drawn are of the new place alone.
  await page.keyboard.press("Space");
  await page.waitForFunction(() => document.getElementById("play-label").textContent === "Play");
  const before = await picture();
  await page.locator("#seek").fill("6");
  await page.waitForFunction(() => document.getElementById("player-position").textContent.startsWith("00:00:06"));
  await page.waitForFunction((old) => document.querySelector("canvas.picture").toDataURL() !== old, before);
  assert.equal((await replayed.player()).playing, false, "still paused");
  await page.waitForTimeout(1000); // longer than the slider is held where it was put
  assert.equal(await position_s(), 6, "and stays there");
  const atSix = await picture();
  assert.ok((await ink(page, "#wind-chart canvas")) > 0.005, "with the wind that led up to it");

  await page.keyboard.press("ArrowLeft");
  await page.waitForFunction(() => document.getElementById("player-position").textContent.startsWith("00:00:01"));
  await page.waitForFunction((old) => document.querySelector("canvas.picture").toDataURL() !== old, atSix);
  const atOne = await picture();
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction(() => document.getElementById("player-position").textContent.startsWith("00:00:06"));
  // Not compared with the first picture of second 6: a frame was taken at that very moment, and is on either side of it.
  await page.waitForFunction((old) => document.querySelector("canvas.picture").toDataURL() !== old, atOne);

  await page.locator("#seek").focus();
  assert.match(await page.locator("#seek").getAttribute("aria-valuetext"), /00:00:06 of 00:00:0[78]/);
  await page.keyboard.press("Home");
  await page.waitForFunction(() => document.getElementById("player-position").textContent.startsWith("00:00:00"));
  await page.keyboard.press("Space");
  await page.waitForFunction(() => document.getElementById("play-label").textContent === "Pause");
  await page.waitForFunction(() => document.getElementById("player-position").textContent.startsWith("00:00:02"));
  // The end is waited at, and playing from there is playing from the begin.
  await page.keyboard.press("End");
  await page.waitForFunction(() => document.getElementById("player-position").textContent.includes("the end"));
  await page.keyboard.press("Space");
  await page.waitForFunction(() => document.getElementById("player-position").textContent.startsWith("00:00:01"));
  assert.deepEqual(await seriousFaults(page), []);
  assert.deepEqual(await smallButtons(page), []);
  await page.screenshot({ path: join(out, "page-replay.png") });
  assert.deepEqual(errors, []);
});

test("marks of a recording stand on the slider", async (t) => {
  const own = await startOwn(t, ["--replay"]);
  const { page } = await open(t, own.url, { width: 390, height: 844, touch: true });
  await page.waitForSelector(".seek-mark");
  const places = await page.locator(".seek-mark").evaluateAll((marks) => {
    const track = document.getElementById("seek").getBoundingClientRect();
    return marks.map((mark) => (mark.getBoundingClientRect().left - track.left) / track.width);
  });
  assert.equal(places.length, 2);
  assert.ok(Math.abs(places[0] - 95 / 600) < 0.06 && Math.abs(places[1] - 400 / 600) < 0.06, String(places));
  await page.waitForTimeout(500);
  assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 390);
  await page.screenshot({ path: join(out, "page-replay-phone.png") });
});

test("a replay has its controls", async (t) => {
  const own = await startOwn(t, ["--replay", "--no-target"]);
  const { page, errors } = await open(t, own.url);
  await page.waitForSelector("#player:visible");
  await page.waitForSelector("#mark", { state: "hidden" });
  await waitForLife(page);
  await page.keyboard.press("Space");
  await page.waitForFunction(() => document.getElementById("play-label").textContent === "Play");
  await page.waitForTimeout(3000);
  assert.equal(await page.locator("#wind-measured.stale").count(), 0, "paused is not stale");
  await page.getByRole("button", { name: "4 ×" }).click();
  await page.waitForFunction(() => document.querySelector("#speeds .on")?.textContent === "4 ×");
  await page.keyboard.press("Space");
  await page.waitForFunction(() => document.getElementById("play-label").textContent === "Pause");
  assert.equal(await text(page, "#estimate-reason"), "Nothing is tracked in this recording.");
  assert.deepEqual(await seriousFaults(page), []);
  assert.deepEqual(errors, []);
});
