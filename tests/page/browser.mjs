// A browser without a window, a page in it, and what the page must never do.
import assert from "node:assert/strict";
import { createServer } from "node:net";
import { MockServer, require } from "./mock_server.mjs";

// Nothing of the browser's own goes anywhere; WebGL is drawn in software.
const flags = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

export async function launch(executablePath) {
  const { chromium } = require("playwright-core");
  return chromium.launch({ executablePath, headless: true, args: flags });
}

export const freePort = () => new Promise((done) => {
  const server = createServer().listen(0, "127.0.0.1", () => {
    const { port } = server.address();
    server.close(() => done(port));
  });
});

/** Waits until `look` gives something true; nothing is slept for. */
export async function until(look, what, patience = 15_000) {
  const end = performance.now() + patience;
  for (;;) {
    const value = await look();
    if (value) return value;
    assert.ok(performance.now() < end, `${what}: not within ${patience / 1000} s`);
    await new Promise((done) => setTimeout(done, 40));
  }
}

/** One pixel of the canvas covers two of the page each way: software draws a quarter as many, sizes and places are the same. */
export const rough = { deviceScaleFactor: 0.5 };
/** For pictures to be looked at. */
export const sharp = { deviceScaleFactor: 1 };

/**
 * Opens the page of a mock server and looks after it: no error on the console but `allowed` ones, nothing asked of others.
 * @param {{server?: object, path?: string, context?: object, allowed?: RegExp, before?: Function}} options
 * @param {(page, server: MockServer) => Promise<void>} body
 */
export async function withPage(browser, { server: serverOptions = {}, path = "", context: looks = {}, allowed = null, before = null }, body) {
  const server = await new MockServer(serverOptions).listen();
  const context = await browser.newContext({ viewport: { width: 1280, height: 720 }, colorScheme: "dark", ...rough, ...looks });
  try {
    if (before) await context.addInitScript(before);
    const page = await context.newPage();
    const errors = watch(page, server.address);
    await page.goto(server.address + path);
    await body(page, server, context);
    assert.deepEqual(errors.filter((error) => !allowed?.test(error)), [], "the page's console");
  } finally {
    await context.close();
    await server.close();
  }
}

/** @returns a list that fills with errors of the console and with requests that leave the server */
export function watch(page, home) {
  const errors = [];
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(error.stack));
  page.on("request", (request) => {
    if (!request.url().startsWith(home) && !request.url().startsWith("blob:")) errors.push(`asked for ${request.url()}`);
  });
  return errors;
}

export const figures = (page) => page.evaluate(() => window.lcmslam.figures());

/** Where a place of the map is on the page, in pixels. */
export function pixel(page, place) {
  return page.evaluate(([x, y, z]) => {
    const { camera, canvas } = window.lcmslam.stage;
    const at = camera.position.clone().set(x, y, z).project(camera);
    return { x: ((at.x + 1) / 2) * canvas.clientWidth, y: ((1 - at.y) / 2) * canvas.clientHeight };
  }, place);
}

/** Looks straight down on a place. */
export function lookDown(page, [x, y], distance = 5) {
  return page.evaluate(([x, y, distance]) => {
    const { view } = window.lcmslam;
    view.restore({ at: [x, y, 0], turn: [-Math.PI, Math.PI / 2 - 0.001], far: distance, view: "free", follow: false });
    window.lcmslam.stage.invalidate();
  }, [x, y, distance]);
}

export async function clickPlace(page, place) {
  const { x, y } = await pixel(page, place);
  await page.mouse.click(x, y);
}
