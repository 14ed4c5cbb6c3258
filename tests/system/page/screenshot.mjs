// A picture of the live page:
//   node tests/system/page/screenshot.mjs URL OUT.png [--width 1440] [--height 900] [--theme dark|light] [--wait SECONDS]
//                                         [--scale 1] [--touch] [--full] [--press KEYS] [--anyway]
// It waits for pictures and wind, then for --wait seconds (default 3). --press: keys to press first, one letter each.
// --full: the whole page, not only what fits. --anyway: do not wait for life.
import { parseArgs } from "node:util";
import { openBrowser, openPage, waitForLife } from "./browser.mjs";

const { values, positionals } = parseArgs({
  allowPositionals: true,
  options: {
    width: { type: "string", default: "1440" },
    height: { type: "string", default: "900" },
    theme: { type: "string", default: "dark" },
    wait: { type: "string", default: "3" },
    scale: { type: "string", default: "1" },
    touch: { type: "boolean", default: false },
    full: { type: "boolean", default: false },
    press: { type: "string", default: "" },
    anyway: { type: "boolean", default: false },
  },
});
const [url, out] = positionals;
if (out === undefined) {
  console.error("usage: node tests/system/page/screenshot.mjs URL OUT.png [--width N] [--height N] [--theme dark|light] [--wait SECONDS]");
  process.exit(2);
}

const browser = await openBrowser();
try {
  const { page, errors } = await openPage(browser, url, {
    width: Number(values.width),
    height: Number(values.height),
    theme: values.theme,
    touch: values.touch,
    scale: Number(values.scale),
  });
  if (!values.anyway) await waitForLife(page);
  for (const key of values.press) {
    await page.keyboard.press(key);
    await page.waitForTimeout(300);
  }
  await page.waitForTimeout(Number(values.wait) * 1000);
  await page.screenshot({ path: out, fullPage: values.full });
  for (const error of errors) console.error(`console: ${error}`);
} finally {
  await browser.close();
}
