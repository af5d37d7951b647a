// node tests/page/many_points.mjs [MILLIONS]: a cloud of so many points (6) in headless Chromium with software rendering, on a
// desk and on a phone: how many are kept and drawn, and the frames a second while the view turns.
import { figures, launch, until } from "./browser.mjs";
import { pointsOf } from "./kitchen.mjs";
import { MockServer } from "./mock_server.mjs";

const wanted = 1e6 * Number(process.argv[2] ?? 6);
const turning = 6; // s
const server = await new MockServer({ story: false }).listen();
let keyframe = 0;
for (let put = 0; put < wanted; ++keyframe) {
  const pose = { x: 6 * (keyframe % 20), y: 6 * Math.floor(keyframe / 20), yaw: 0, z: 0 };
  for (const message of pointsOf(keyframe, { x: 1.2, y: 0.1, yaw: keyframe }, 20_000)) {
    const header = JSON.parse(message.subarray(4, 4 + message.readUInt32LE(0)));
    put += header.n;
    header.T[0] += pose.x;
    header.T[1] += pose.y;
    server.put(rewritten(message, header));
  }
}

/** The message with another header of at most its length. */
function rewritten(message, header) {
  const length = message.readUInt32LE(0);
  const text = Buffer.from(JSON.stringify(header, (_, value) => (typeof value === "number" ? Math.round(value * 1e4) / 1e4 : value)));
  const copy = Buffer.from(message);
  copy.fill(" ", 4, 4 + length);
  text.copy(copy, 4);
  return copy;
}

const browser = await launch("/usr/bin/chromium");
for (const [name, looks] of [["desk", { viewport: { width: 1280, height: 720 } }],
  ["phone", { viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true }]]) {
  const page = await (await browser.newContext(looks)).newPage();
  await page.goto(server.address);
  let before = "";
  await until(async () => {
    const { points, drawn } = (await figures(page)) ?? {};
    const settled = points > 0 && `${points} ${drawn}` === before;
    before = `${points} ${drawn}`;
    await page.waitForTimeout(4000);
    return settled;
  }, "all points", 240_000);
  const { points, drawn } = await figures(page);
  const rate = await page.evaluate((turning) => new Promise((done) => {
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
  const memory = await page.evaluate(() => performance.memory?.usedJSHeapSize ?? 0);
  console.log(`${name}: ${(points / 1e6).toFixed(2)} of ${(wanted / 1e6).toFixed(1)} million points kept (${keyframe} keyframes), ` +
    `${(drawn / 1e6).toFixed(2)} million drawn at rest, ${rate.toFixed(1)} frames/s while turning, ${(memory / 1e6).toFixed(0)} MB of JavaScript`);
  await page.close();
}
await browser.close();
await server.close();
process.exit(0);
