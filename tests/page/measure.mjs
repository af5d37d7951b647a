// node tests/page/measure.mjs [ADDRESS]: how soon the page shows points and how many frames a second it draws while it turns,
// in headless Chromium with software rendering at 1280 x 720. Without ADDRESS against the mock server's kitchen.
import { launch, figures, until } from "./browser.mjs";
import { MockServer } from "./mock_server.mjs";

const turning = 6; // s
const server = process.argv[2] ? null : await new MockServer({ pace: 4 }).listen();
const browser = await launch("/usr/bin/chromium");
const page = await (await browser.newContext({ viewport: { width: 1280, height: 720 } })).newPage();
await page.goto(process.argv[2] ?? server.address);
const first = await until(() => page.evaluate(() => performance.getEntriesByName("lcmslam-first-map")[0]?.startTime), "points");
console.log(`first points: ${(first / 1000).toFixed(2)} s`);
if (server) {
  await until(async () => (await figures(page)).keyframes > 30, "the whole kitchen", 60_000);
  clearInterval(server.timer);
}
for (const name of ["mesh", "points"]) {
  await page.evaluate((name) => {
    for (const each of ["mesh", "points"]) window.lcmslam.switches.set(each, each === name);
  }, name);
  const frames = await page.evaluate((turning) => new Promise((done) => {
    const { view, stage } = window.lcmslam;
    const begin = performance.now();
    const from = stage.frames;
    const turn = () => {
      view.orbit(0.02, 0);
      if (performance.now() - begin < turning * 1000) requestAnimationFrame(turn);
      else done((stage.frames - from) / turning);
    };
    turn();
  }), turning);
  const { triangles, drawn, points } = await figures(page);
  console.log(`${name}: ${frames.toFixed(1)} frames/s while turning (${triangles} triangles; ${drawn} of ${points} points drawn)`);
}
await browser.close();
await server?.close();
process.exit(0);
