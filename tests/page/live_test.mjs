// What is seen: maps come, grow, bend, and survive a server that goes and comes back.
import assert from "node:assert/strict";
import { figures, sharp, until, withPage } from "./browser.mjs";
import { encode, floats } from "./messages.mjs";
import { pointsOf, onTheRound, surface } from "./kitchen.mjs";

const position = (page, keyframe) => page.evaluate((k) => window.lcmslam.views.points.poses.group(k).position.toArray(), keyframe);

/** A page that showed two keyframes when its server went, which is there again and has but one of them. */
async function withLostServer(browser, body) {
  const lost = /WebSocket connection|ERR_CONNECTION_(REFUSED|RESET)|ERR_INCOMPLETE_CHUNKED_ENCODING/;
  await withPage(browser, { allowed: lost, server: { story: false } }, async (page, server) => {
    for (const k of [0, 1]) for (const message of pointsOf(k, onTheRound(k / 30))) server.put(message);
    server.put(encode({ channel: "about", key: "", title: "kitchen", can: [], source: "live" }));
    await until(async () => (await figures(page)).points > 11_000, "both keyframes");
    const { port } = server;
    await server.close();
    await page.getByText("The connection to the map server is lost").waitFor();
    for (const level of [0, 1, 2]) server.board.delete(`points 1/${level}`);
    await server.listen(port);
    await body(page, server);
  });
}

export const tests = {
  async "first points come at once"(browser, { measured }) {
    await withPage(browser, {}, async (page) => {
      const seconds = await until(() => page.evaluate(() => performance.getEntriesByName("lcmslam-first-map")[0]?.startTime), "points") / 1000;
      measured("first points", `${seconds.toFixed(2)} s after the address was opened`);
      assert.ok(seconds < 5, `first points after ${seconds} s`); // the bar is 1 s; a busy machine must not fail the test
    });
  },

  async "both maps appear and grow, and the map bends as a loop closes"(browser, { picture }) {
    await withPage(browser, { context: sharp, server: { pace: 3 } }, async (page) => {
      const first = await until(async () => ((await figures(page)).landmarks > 0 ? figures(page) : null), "landmarks");
      await until(async () => {
        const now = await figures(page);
        const denser = now.points > first.points || now.triangles > first.triangles; // the surface takes the points' place
        return denser && now.landmarks > first.landmarks && now.triangles > 0;
      }, "both maps grow");
      await until(async () => (await figures(page)).keyframes > 22, "keyframes");
      const before = await position(page, 20);
      await picture(page, "growing");
      await until(async () => (await figures(page)).loops > 0, "a loop", 30_000);
      await until(async () => Math.hypot(...(await position(page, 20)).map((c, i) => c - before[i])) > 0.05, "the map bends");
      await picture(page, "loop");
    });
  },

  async "positions, health and the image are told in words"(browser) {
    await withPage(browser, {}, async (page) => {
      await page.getByText("All is well: both mappers track").waitFor();
      await page.getByText(/features seen again/).waitFor();
      await page.getByText("off by").first().waitFor();
      assert.match(await page.title(), /kitchen/);
      await page.getByRole("button", { name: /^Processes/ }).click();
      await page.getByText("3 messages of WHEELS were lost: look at the network's load").waitFor();
    });
  },

  async "a server that goes and comes back is found again"(browser) {
    await withLostServer(browser, async (page, server) => {
      await until(() => page.evaluate(() => document.documentElement.dataset.connection === "open"), "the connection");
      assert.ok((await figures(page)).points > 0, "the map stays while the connection is away");
      await until(async () => (await figures(page)).points < 7000, "what the server has no more goes");
    });
  },

  async "what the server has no more goes, too, while the robot drives on"(browser) {
    await withLostServer(browser, async (page, server) => {
      await until(() => server.live.size === 1 && [...server.live][0].fresh.size === 0, "the page again");
      for (const { socket } of server.live) socket.send(encode({ channel: "whole", key: "" }));
      let way = 1;
      await until(async () => {
        server.put(encode({ channel: "path", key: "icp/0" }, floats([0, 0, 0, (way += 0.01), 0, 0])));
        return (await figures(page)).points < 7000;
      }, "what the server has no more goes");
    });
  },

  async "points give way to the surface where that is, and there alone"(browser) {
    await withPage(browser, { server: { story: false } }, async (page, server) => {
      const drawn = async () => (await figures(page)).drawn;
      server.put(encode({ channel: "about", key: "", title: "kitchen", can: [], source: "live" }));
      for (const message of pointsOf(0, onTheRound(0))) server.put(message);
      const T = [30, 0, 1.1, 0.5, -0.5, 0.5, -0.5]; // a keyframe of which the server has no images any more
      const far = [[30, 0], [31, 1], [32, -1]].map(([x, y]) => Int16Array.of(1000 * y, 0, 1000 * (x - 28)));
      server.put(encode({ channel: "points", key: "1/0", keyframe: 1, level: 0, n: 3, unit: 0.001, T }, Buffer.concat([...far.map(({ buffer }) => Buffer.from(buffer)), Buffer.alloc(9)])));
      await until(async () => (await figures(page)).points > 6000, "points");
      await page.evaluate(() => {
        const { view } = window.lcmslam;
        view.restore({ at: [15, 0, 0], turn: [-1.5, 0.6], far: 40, view: "free", follow: false });
        window.lcmslam.stage.invalidate();
      });
      await until(async () => (await drawn()) > 6000, "all points are drawn");
      for (const { message } of surface(0.05)) server.put(message);
      await until(async () => (await figures(page)).triangles > 20_000, "the surface");
      await until(async () => (await drawn()) === 3, "the far ones alone are drawn");
      await page.keyboard.press("1"); // without the surface
      await until(async () => (await drawn()) > 6000, "all points are drawn again");
      await page.keyboard.press("1");
      await until(async () => (await drawn()) === 3, "the far ones alone");
      for (const name of ["off", "on"]) await page.keyboard.press("2");
      await until(async () => (await drawn()) > 6000, "whoever chooses points sees all of them");
    });
  },

  async "the robot is where a mapper says it is now, and an old place looks old"(browser) {
    await withPage(browser, { server: { story: false } }, async (page, server) => {
      const put = (icp, fastslam) => server.put(encode({ channel: "poses", key: "", utime: 1, icp: { T: [0, 0, 0, 1, 0, 0, 0], status: icp }, fastslam: { T: [3, 0, 0, 1, 0, 0, 0], status: fastslam } }));
      const robot = () => page.evaluate(() => [window.lcmslam.views.robot.main, window.lcmslam.views.robot.edge.opacity]);
      server.put(encode({ channel: "about", key: "", title: "kitchen", can: [], source: "live" }));
      put("TRACKING", "TRACKING");
      await until(async () => (await robot())[0] === "icp", "icp's robot");
      await page.getByText("tracking").first().waitFor();
      put("LOST", "TRACKING");
      await until(async () => (await robot()).join() === "fastslam,0.9", "fastslam's robot while icp guesses");
      put("LOST", "SILENT");
      await until(async () => (await robot()).join() === "icp,0.25", "a guess looks like one");
      put("TRACKING", "TRACKING");
      await until(async () => (await robot()).join() === "icp,0.9", "icp's robot again");
      put("SILENT", "TRACKING");
      await until(async () => (await robot())[0] === "fastslam", "fastslam's robot");
      await page.locator(".state.bad", { hasText: "silent" }).waitFor();
      put("SILENT", "SILENT");
      await until(async () => (await robot()).join() === "icp,0.25", "a robot of once");
    });
  },

  async "errors of minutes ago are not those of now"(browser) {
    await withPage(browser, { server: { story: false } }, async (page, server) => {
      const put = (seconds, errors) => server.put(encode({ channel: "poses", key: "", utime: seconds * 1e6, icp: { T: [0, 0, 0, 1, 0, 0, 0], status: "TRACKING" }, ...errors }));
      server.put(encode({ channel: "about", key: "", title: "kitchen", can: [], source: "live" }));
      await page.getByText("Waiting for the first position").waitFor();
      for (const seconds of [1, 2, 3]) {
        put(seconds, { errors: { icp: 0.03 } });
        await page.waitForFunction((utime) => window.lcmslam.board.get("poses")?.header.utime === utime, seconds * 1e6);
      }
      await page.getByText("off by 3.0 cm").waitFor();
      await page.getByText("Error against the truth").waitFor();
      put(61, {});
      await page.getByText("60 s ago").waitFor();
      put(130, {});
      await page.getByText("Error against the truth").waitFor({ state: "hidden" });
      assert.equal(await page.getByText("off by").count(), 0);
    });
  },

  async "a network that goes is said, though no socket closes, and found again"(browser) {
    await withPage(browser, {}, async (page, server) => {
      await page.getByText("All is well: both mappers track").waitFor();
      await until(() => server.heard.some((each) => each.do === "ping"), "a ping");
      server.isCut = true;
      await page.getByText("has not answered for some seconds; what is shown is old").waitFor({ timeout: 30_000 });
      await page.getByText("The connection to the map server is lost").waitFor({ timeout: 30_000 });
      await until(() => server.swallowed.length > 0, "another try", 30_000);
      server.isCut = false;
      await page.getByText("All is well: both mappers track").waitFor({ timeout: 30_000 });
    });
  },

  async "commands go on when their socket alone breaks"(browser) {
    await withPage(browser, {}, async (page, server) => {
      await until(() => server.heard.some((each) => each.do === "ping"), "a ping");
      for (const socket of server.commands) socket.terminate();
      server.heard.length = 0;
      await until(() => server.heard.some((each) => each.do === "ping"), "a ping again", 8000);
      assert.ok(await page.evaluate(() => document.documentElement.dataset.connection === "open"));
    });
  },

  async "what is gone is taken away"(browser) {
    await withPage(browser, { server: { story: false } }, async (page, server) => {
      for (const message of pointsOf(0, onTheRound(0))) server.put(message);
      await until(async () => (await figures(page)).points > 0, "points");
      server.takeAway(encode({ channel: "points", key: "", gone: true }));
      await until(async () => (await figures(page)).points === 0, "no points");
      await page.getByText("Connecting to the map server").first().waitFor(); // no `about` yet
      server.put(encode({ channel: "about", key: "", title: "kitchen", can: [], source: "live" }));
      await page.getByText("Waiting for the mapper's first keyframe.").waitFor();
    });
  },

  async "a message that cannot be read is said and survived"(browser) {
    await withPage(browser, { server: { story: false }, allowed: /^live: a header of/ }, async (page, server) => {
      await until(() => server.live.size === 1, "the page");
      for (const { socket } of server.live) socket.send(Buffer.from([255, 255, 0, 0, 1, 2]));
      for (const message of pointsOf(0, onTheRound(0))) server.put(message);
      await until(async () => (await figures(page)).points > 0, "points after it");
    });
  },

  async "a log has a slider"(browser) {
    await withPage(browser, { server: { story: false } }, async (page, server) => {
      server.put(encode({ channel: "about", key: "", title: "kitchen.lcmlog", can: ["play"], source: "log" }));
      server.put(encode({ channel: "time", key: "", begin: 1e15, now: 1e15 + 2e6, end: 1e15 + 1e7, playing: true, speed: 1 }));
      await page.getByText("0:02 of 0:10").waitFor();
      await page.getByRole("button", { name: "Pause" }).click();
      await until(() => server.heard.some((each) => each.do === "play" && each.playing === false), "pause");
      await page.getByRole("slider", { name: "Time of the log" }).focus();
      await page.keyboard.press("End");
      await until(() => server.heard.some((each) => each.do === "play" && each.at === 1e15 + 1e7), "the end");
    });
  },

  async "a slider that is dragged away and back follows the log again"(browser) {
    await withPage(browser, { server: { story: false } }, async (page, server) => {
      const time = (now) => server.put(encode({ channel: "time", key: "", begin: 0, now: now * 1e6, end: 1e8, playing: false, speed: 1 }));
      server.put(encode({ channel: "about", key: "", title: "kitchen.lcmlog", can: ["play"], source: "log" }));
      time(50);
      const slider = page.getByRole("slider", { name: "Time of the log" });
      await page.getByText("0:50 of 1:40").waitFor();
      const box = await slider.boundingBox();
      const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x + 60, y, { steps: 4 });
      await page.mouse.move(x, y, { steps: 4 });
      await page.mouse.up();
      time(70);
      await page.getByText("1:10 of 1:40").waitFor({ timeout: 5000 });
      assert.equal(await slider.inputValue(), "700");
    });
  },
};
