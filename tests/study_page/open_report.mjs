// node open_report.mjs REPORT PICTURES: opens REPORT/index.html in Chromium, wide and light, on a phone and dark. Every chart must
// be drawn, named and legible. Exit code 77: no Chromium here. LCMSLAM_PAGE_MODULES: where node_modules with playwright-core are.
import assert from "node:assert/strict";
import { existsSync, mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [report, pictures] = process.argv.slice(2).map((folder) => resolve(folder));
const chromiumPath = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium"].find(existsSync);
if (!chromiumPath) {
  console.log("skipped: no /usr/bin/chromium; apt-get install chromium");
  process.exit(77);
}
const { chromium } = createRequire(join(process.env.LCMSLAM_PAGE_MODULES, "x.js"))("playwright-core");
const told = JSON.parse(readFileSync(join(report, "report.json"), "utf8"));
const address = pathToFileURL(join(report, "index.html")).href;

/** What a reader would stumble over, in words. */
function faults() {
  const found = [];
  const seen = (element) => element.checkVisibility({ visibilityProperty: true }) && element.getClientRects().length > 0;
  const wide = document.documentElement.scrollWidth - innerWidth;
  if (wide > 0) found.push(`the page is ${wide} px wider than the screen`);
  for (const figure of document.querySelectorAll("figure.chart:not(.missing)")) {
    const name = `${figure.closest("section").id}: ${figure.querySelector("figcaption").textContent}`;
    const svg = figure.querySelector(".frame svg");
    if (!svg) { found.push(`${name}: not drawn`); continue; }
    const marks = [...svg.querySelectorAll("[aria-label=line] path, [aria-label=dot] *, [aria-label=rect] rect, [aria-label=cell] rect")];
    if (!marks.some((mark) => mark.getBoundingClientRect().width + mark.getBoundingClientRect().height > 1)) found.push(`${name}: no marks`);
    if (/NaN|Infinity/.test(svg.outerHTML)) found.push(`${name}: NaN is drawn`);
    if (svg.querySelectorAll("[aria-label^='x-axis tick label'] text").length < 1) found.push(`${name}: no ticks along x`);
    if (svg.querySelectorAll("[aria-label^='y-axis tick label'] text").length < 1) found.push(`${name}: no ticks along y`);
    if (!figure.querySelector(".legend svg")) found.push(`${name}: no legend`);
    for (const axis of figure.querySelectorAll("p.axis")) if (axis.textContent.replace(/[↑→]/g, "").trim() === "") found.push(`${name}: an axis without a name`);
    const ticks = [...svg.querySelectorAll("[aria-label^='x-axis tick label'] text")].map((text) => text.getBoundingClientRect());
    ticks.sort((a, b) => a.left - b.left);
    if (ticks.some((box, i) => i > 0 && box.left < ticks[i - 1].right - 0.5)) found.push(`${name}: ticks along x overlap`);
  }
  for (const figure of document.querySelectorAll("figure.missing")) found.push(`nothing to draw: ${figure.closest("section").id}: ${figure.textContent}`);
  for (const image of document.images) {
    if (image.naturalWidth === 0) found.push(`no picture: ${image.alt}`);
    if (image.alt === "") found.push(`a picture without words: ${image.closest("section").id}`);
  }
  for (const element of [...document.querySelectorAll("body *")].filter(seen)) {
    const hasText = [...element.childNodes].some((node) => node.nodeType === Node.TEXT_NODE && node.textContent.trim() !== "");
    if (hasText && parseFloat(getComputedStyle(element).fontSize) < 12) found.push(`small text: ${element.textContent}`);
  }
  return found;
}

const looks = {
  wide: { viewport: { width: 1280, height: 900 }, colorScheme: "light" },
  dark: { viewport: { width: 900, height: 900 }, colorScheme: "dark" },
  phone: { viewport: { width: 390, height: 844 }, colorScheme: "light", isMobile: true, hasTouch: true },
};
mkdirSync(pictures, { recursive: true });
const browser = await chromium.launch({ executablePath: chromiumPath, headless: true, args: ["--no-sandbox", "--disable-gpu"] });
let failed = 0;
for (const [name, look] of Object.entries(looks)) {
  const page = await browser.newPage(look);
  const errors = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(error.stack));
  page.on("request", (request) => !/^(file|data|blob):/.test(request.url()) && errors.push(`asked for ${request.url()}`));
  await page.goto(address);
  await page.waitForFunction(() => [...document.querySelectorAll(".frame")].every((frame) => frame.firstChild), null, { timeout: 30_000 });
  errors.push(...await page.evaluate(faults));
  const shown = await page.evaluate(() => [...document.querySelectorAll("section")].map((section) => section.id));
  assert.deepEqual(shown, told.experiments.map((experiment) => experiment.name), "an experiment is not shown");
  const drawn = await page.evaluate(() => document.querySelectorAll("figure.chart").length);
  assert.equal(drawn, told.experiments.reduce((sum, { charts = [], heat_maps = [] }) => sum + charts.length + heat_maps.length, 0));
  await page.screenshot({ path: join(pictures, `${name}.png`) });
  await page.addStyleTag({ content: ".unseen { display: none; }" });
  for (const { name: experiment } of told.experiments) {
    // Alone: else all of the page, 40 m of paper, is drawn anew for each picture.
    await page.evaluate((shown) => document.querySelectorAll("section").forEach((section) => section.classList.toggle("unseen", section.id !== shown)), experiment);
    await page.locator(`section[id="${experiment}"]`).screenshot({ path: join(pictures, `${name}_${experiment}.png`) });
  }
  console.log(`${errors.length ? "FAILED" : "good  "} ${name}: ${shown.length} experiments, ${drawn} charts`);
  for (const error of errors) console.log(`  ${error}`);
  failed += errors.length;
  await page.close();
}
await browser.close();
process.exit(failed ? 1 : 0);
