// Starting a headless Chromium, and finding one.
import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

const kPlaces = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

/** Path of a Chromium on this machine (the environment's CHROMIUM first), or undefined. */
export function findChromium() {
  return kPlaces.find((path) => path !== undefined && path !== "" && existsSync(path));
}

export async function openBrowser() {
  const executablePath = findChromium();
  if (executablePath === undefined) throw new Error("no Chromium found: apt-get install chromium, or set CHROMIUM to its path");
  return chromium.launch({
    executablePath,
    args: [
      "--no-sandbox",
      "--disable-gpu",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
    ],
  });
}

/** A page in the wanted theme and size; what it writes to its console as an error or throws is collected in `errors`. */
export async function openPage(browser, url, { width = 1440, height = 900, theme = "dark", touch = false, scale = 1 } = {}) {
  const context = await browser.newContext({
    viewport: { width, height },
    colorScheme: theme,
    hasTouch: touch,
    isMobile: touch,
    deviceScaleFactor: scale,
  });
  const page = await context.newPage();
  const errors = [];
  page.on("console", (message) => {
    if (message.type() === "error" || message.type() === "warning") errors.push(message.text());
  });
  page.on("pageerror", (error) => errors.push(String(error)));
  await page.goto(url);
  return { page, errors, context };
}

/** Waits until pictures have been drawn and the measured wind is a number. */
export async function waitForLife(page, timeout_ms = 20_000) {
  await page.waitForFunction(
    () => {
      const canvases = [...document.querySelectorAll("canvas.picture")];
      const drawn = canvases.length > 0 && canvases.every((canvas) => canvas.width > 300);
      return drawn && /\d/.test(document.getElementById("wind-speed")?.textContent ?? "");
    },
    undefined,
    { timeout: timeout_ms },
  );
}
