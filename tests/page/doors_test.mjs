// Who comes in: the token, and the page as one file without a server.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { figures, until, watch, withPage } from "./browser.mjs";
import { landmarks, layers, onTheRound, pointsOf, surface } from "./kitchen.mjs";
import { carried, encode } from "./messages.mjs";

export const tests = {
  async "without the token there is no page, with it the address forgets it"(browser) {
    await withPage(browser, { server: { token: "secret" }, allowed: /401/ }, async (page, server) => {
      assert.match(await page.textContent("body"), /wants the token/);
      await page.goto(`${server.address}?token=wrong`);
      assert.match(await page.textContent("body"), /wants the token/);
      await page.goto(`${server.address}?token=secret`);
      await until(async () => (await figures(page)).points > 0, "points");
      assert.ok(!(await page.evaluate(() => location.href)).includes("secret"));
    });
  },

  async "a server that was started anew is asked for its new token"(browser) {
    await withPage(browser, { server: { token: "old" }, path: "?token=old", allowed: /WebSocket|ERR_|401/ }, async (page, server) => {
      await until(async () => (await figures(page)).points > 0, "points");
      const { port } = server;
      await server.close();
      server.token = "new";
      await server.listen(port);
      const dialog = page.getByRole("dialog", { name: "Token" });
      await dialog.waitFor();
      await dialog.getByRole("textbox").fill("new");
      await dialog.getByRole("button", { name: "Go on" }).click();
      await until(() => page.evaluate(() => document.documentElement.dataset.connection === "open"), "the connection");
    });
  },

  async "a page that carries its map opens as a file, without any server"(browser, { page: built, folder, picture }) {
    const read = (name) => readFileSync(join(built, name), "utf8");
    const messages = [
      encode({ channel: "about", key: "", title: "A kept kitchen", version: 7, source: "file", can: [], frame: "map" }),
      ...[0, 5, 10, 15, 20, 25].flatMap((k) => pointsOf(k, onTheRound(k / 30))),
      ...surface(0.05).map(({ message }) => message), ...landmarks(), ...layers(),
    ];
    const html = read("index.html")
      .replace('<link rel="icon" href="icon.svg" type="image/svg+xml">\n', "")
      .replace('<link rel="stylesheet" href="page.css">', () => `<style>${read("page.css")}</style>`)
      .replace('<script src="page.js"></script>', () => `<script type="application/octet-stream;base64" id="lcmslam-items">${carried(messages)}</script>\n<script>${read("page.js")}</script>`);
    const file = join(folder, "kitchen.html");
    writeFileSync(file, html);
    const context = await browser.newContext({ viewport: { width: 1280, height: 720 } });
    const page = await context.newPage();
    const errors = watch(page, "file:");
    page.on("websocket", () => errors.push("a socket was opened"));
    await page.goto(pathToFileURL(file).href);
    await until(async () => (await figures(page)).triangles > 10_000, "the map");
    await page.getByText("A kept map", { exact: true }).waitFor();
    assert.equal(await page.getByRole("button", { name: "Save", exact: true }).count(), 0);
    await picture(page, "file");
    await context.close();
    assert.deepEqual(errors, []);
  },
};
