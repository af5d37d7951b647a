// What is done: inspect, measure, go-to, drive, save, begin anew.
import assert from "node:assert/strict";
import { clickPlace, figures, lookDown, pixel, until, withPage } from "./browser.mjs";
import { layers, surface, T } from "./kitchen.mjs";
import { encode, floats } from "./messages.mjs";

const all = ["go_to", "drive", "save", "reset", "export", "log", "query"];
const still = { server: { story: false } };

/** The whole kitchen at rest, the robot at its origin. */
async function furnish(page, server, can = all) {
  server.put(encode({ channel: "about", key: "", title: "kitchen", source: "live", can, robot: { length: 0.6, width: 0.5, height: 0.9 } }));
  for (const { message } of surface(0.1)) server.put(message);
  for (const message of layers()) server.put(message);
  server.put(encode({ channel: "poses", key: "", utime: 1, icp: { T: T(0, 0, 0, 0), status: "TRACKING" } }));
  await until(async () => (await figures(page)).triangles > 10_000, "the kitchen");
}

const heard = (server, what) => server.heard.filter((each) => each.do === what);

export const tests = {
  async "a click tells position, clearance and plane"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      await lookDown(page, [1.5, -1]);
      await clickPlace(page, [1.4, -0.9, 0.74]);
      const card = page.getByRole("region", { name: "Tool" });
      await card.getByText(/^1\.\d\d, -0\.(8|9)\d, 0\.7\d m$/).waitFor();
      await card.getByText("table, 1.12 m²").waitFor();
      await card.getByText("42.0 cm").waitFor();
      assert.deepEqual(heard(server, "query").map(({ question }) => question.ask).sort(), ["distance", "space"]);
      await page.keyboard.press("Escape");
      await card.waitFor({ state: "hidden" });
      await page.keyboard.press("Enter"); // the same without a pointer, at the middle of the view
      await card.getByText("1.50, -1.00, 0.74 m").waitFor();
    });
  },

  async "two clicks measure"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      await lookDown(page, [0.5, -0.5]);
      await page.keyboard.press("m");
      await clickPlace(page, [0, -1, 0]);
      await clickPlace(page, [0.8, -1, 0]);
      const text = await page.locator(".tool-card dd").first().textContent();
      assert.ok(Math.abs(parseFloat(text) - 80) < 2.5 && text.endsWith("cm"), `80 cm measured as ${text}`);
    });
  },

  async "a map of 300 m is seen from afar, and its ground is there for tools"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      await page.evaluate(() => {
        const { view } = window.lcmslam;
        const at = (x, y) => view.target.clone().set(x, y, 0);
        view.extent = () => ({ centre: at(0, 0), places: [at(-150, -80), at(150, -80), at(150, 80), at(-150, 80)] });
      });
      await lookDown(page, [50, 20], 250);
      const far = () => page.evaluate(() => window.lcmslam.view.distance);
      await page.keyboard.press("-");
      assert.ok((await far()) > 250, `one step back leads to ${await far()} m`);
      for (let i = 0; i < 40; ++i) await page.keyboard.press("-");
      assert.ok((await far()) < 2000, `${await far()} m away the map is lost`);
      await lookDown(page, [50, 20], 250);
      await clickPlace(page, [50, 20, 0]);
      await page.getByRole("region", { name: "Tool" }).getByText("50.00, 20.00, 0.00 m").waitFor();
    });
  },

  async "go-to sends place and heading"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      await lookDown(page, [0.5, 0]);
      await page.getByRole("button", { name: /Send the robot/ }).click();
      const [from, to] = [await pixel(page, [0.6, -0.4, 0]), await pixel(page, [0.6, 0.4, 0])];
      await page.mouse.move(from.x, from.y);
      await page.mouse.down();
      await page.mouse.move(to.x, to.y, { steps: 4 });
      await page.mouse.up();
      const [goal] = await until(() => heard(server, "go_to").length > 0 && heard(server, "go_to"), "go_to");
      assert.ok(Math.hypot(goal.x - 0.6, goal.y + 0.4) < 0.02 && Math.abs(goal.yaw - Math.PI / 2) < 0.05, JSON.stringify(goal));
      await page.getByText("The goal was published on GOAL").waitFor();
    });
  },

  async "two fingers move the view and send nobody anywhere"(browser) {
    await withPage(browser, { ...still, context: { hasTouch: true } }, async (page, server, context) => {
      await furnish(page, server);
      await lookDown(page, [0.5, 0]);
      await page.getByRole("button", { name: /Send the robot/ }).click();
      const { x, y } = await pixel(page, [0.6, 0, 0]);
      const session = await context.newCDPSession(page);
      const touch = (type, ...places) => session.send("Input.dispatchTouchEvent", { type, touchPoints: places.map(([dx, dy], id) => ({ x: x + dx, y: y + dy, id })) });
      const distance = () => page.evaluate(() => window.lcmslam.view.distance);
      const far = await distance();
      await touch("touchStart", [-50, 0]);
      await touch("touchStart", [-50, 0], [50, 0]);
      for (let i = 1; i <= 5; ++i) await touch("touchMove", [-50 - 10 * i, 0], [50 + 10 * i, 0]);
      await touch("touchEnd", [-100, 0]);
      await touch("touchEnd");
      await until(async () => (await distance()) < 0.7 * far, "a nearer view");
      await touch("touchStart", [0, 0]); // one finger is a press still
      await touch("touchEnd");
      await until(() => heard(server, "go_to").length > 0, "go_to");
      const goals = heard(server, "go_to");
      assert.equal(goals.length, 1, JSON.stringify(goals));
    });
  },

  async "a drag moves the ground with the pointer, and W moves the view ahead"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      for (const pitch of [0.6, 1.2]) {
        await page.evaluate((pitch) => window.lcmslam.view.restore({ at: [0.5, 0, 0], turn: [-2.3, pitch], far: 5, view: "free", follow: false }), pitch);
        const from = await pixel(page, [0.5, 0, 0]);
        await page.mouse.move(from.x, from.y);
        await page.mouse.down({ button: "right" });
        await page.mouse.move(from.x + 40, from.y + 30, { steps: 5 });
        await page.mouse.up({ button: "right" });
        const to = await pixel(page, [0.5, 0, 0]);
        assert.ok(Math.hypot(to.x - from.x - 40, to.y - from.y - 30) < 16, `from ${JSON.stringify(from)} to ${JSON.stringify(to)}`);
      }
      const ahead = () => page.evaluate(() => {
        const { target, stage } = window.lcmslam.view;
        const looks = target.clone().sub(stage.camera.position);
        return (target.x * looks.x + target.y * looks.y) / Math.hypot(looks.x, looks.y);
      });
      const before = await ahead();
      await page.keyboard.press("w");
      assert.ok((await ahead()) > before + 0.05, `${before} to ${await ahead()}`);
    });
  },

  async "driving stops when keys are let go, and when nobody looks"(browser, { measured }) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      await page.keyboard.press("x");
      await page.keyboard.down("w");
      await until(() => heard(server, "drive").length >= 6, "driving");
      const gaps = heard(server, "drive").map(({ when }, i, list) => (i ? when - list[i - 1].when : 0));
      measured("longest gap between drive messages", `${Math.max(...gaps).toFixed(0)} ms`);
      assert.ok(heard(server, "drive").every(({ linear, angular }) => linear === 1 && angular === 0));
      await page.keyboard.up("w");
      await until(() => heard(server, "drive").at(-1).linear === 0, "a stop");
      await page.keyboard.down("a");
      await until(() => heard(server, "drive").at(-1).angular === 1, "turning");
      await page.evaluate(() => dispatchEvent(new Event("blur")));
      await until(() => heard(server, "drive").at(-1).angular === 0, "a stop as the window loses the focus");
      const so_far = heard(server, "drive").length;
      await until(() => page.evaluate(() => new Promise((done) => setTimeout(() => done(true), 250))), "a quarter of a second");
      assert.equal(heard(server, "drive").length, so_far, "nothing is sent after the stop");
    });
  },

  async "pressing the map while driving, or laying a tool down while it is pressed, harms nothing"(browser) {
    await withPage(browser, still, async (page, server) => { // which looks for errors
      await furnish(page, server);
      await lookDown(page, [0.5, 0]);
      const { x, y } = await pixel(page, [0.6, -0.4, 0]);
      await page.keyboard.press("x");
      await page.mouse.click(x, y);
      await page.keyboard.press("Enter");
      await page.keyboard.down("w");
      await until(() => heard(server, "drive").at(-1)?.linear === 1, "driving");
      await page.keyboard.up("w");
      for (const keys of [["Escape"], ["Escape", "g"], ["x"]]) {
        await page.keyboard.press("g");
        await page.mouse.move(x, y);
        await page.mouse.down();
        for (const key of keys) await page.keyboard.press(key);
        await page.mouse.move(x + 40, y + 40, { steps: 3 });
        await page.mouse.up();
        await page.keyboard.press("Escape");
      }
      assert.equal(heard(server, "go_to").length, 0);
    });
  },

  async "no modifier keeps a robot going"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      await page.keyboard.press("x");
      const turning = () => heard(server, "drive").at(-1)?.angular === 1;
      const stopped = () => heard(server, "drive").at(-1).angular === 0;
      await page.keyboard.down("a");
      await until(turning, "turning");
      await page.evaluate(() => dispatchEvent(new KeyboardEvent("keyup", { key: "æ", code: "KeyA" }))); // beside AltGr
      await until(stopped, "a stop by a key with another name");
      await page.keyboard.up("a");
      for (const name of ["Control", "Alt", "Meta"]) {
        await page.keyboard.down("a");
        await until(turning, "turning again");
        await page.keyboard.down(name);
        await until(stopped, `a stop by ${name}`);
        await page.keyboard.up(name);
        const so_far = heard(server, "drive").length;
        await page.keyboard.down("a"); // repeats, as keys do that are held
        await page.keyboard.down("d");
        await until(() => heard(server, "drive").length > so_far, "a new press");
        assert.equal(heard(server, "drive")[so_far].angular, -1, "what was stopped goes on only by a new press");
        await page.keyboard.up("a");
        await page.keyboard.up("d");
        await until(stopped, "a stop");
      }
    });
  },

  async "over a link that stands no commands pile up to be done later"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      await page.keyboard.press("x");
      await page.keyboard.down("w");
      await until(() => heard(server, "drive").length >= 3, "driving");
      server.isCut = true;
      await page.getByText("Driving has stopped: the map server answers late").waitFor({ timeout: 5000 });
      assert.ok(await page.evaluate(() => document.documentElement.dataset.connection !== "lost"));
      server.isCut = false;
      const so_far = heard(server, "drive").length;
      await until(() => page.evaluate(() => new Promise((done) => setTimeout(() => done(true), 300))), "three periods");
      assert.equal(heard(server, "drive").length, so_far, "only a new press drives on");
    });
  },

  async "the pad drives by shares, and its release stops"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      await page.keyboard.press("x");
      const box = await page.getByRole("application").boundingBox();
      await page.mouse.move(box.x + box.width / 2, box.y + 2);
      await page.mouse.down({ button: "right" });
      await page.mouse.up({ button: "right" });
      await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
      await page.mouse.down();
      await page.mouse.move(box.x + box.width / 2, box.y + box.height / 4);
      await until(() => Math.abs(heard(server, "drive").at(-1)?.linear - 0.5) < 0.05, "half speed");
      assert.ok(heard(server, "drive").every(({ linear }) => Math.abs(linear) < 0.55), "the left button alone drives");
      await page.mouse.up();
      await until(() => heard(server, "drive").at(-1).linear === 0, "a stop");
    });
  },

  async "saving says so, beginning anew wants a second press, errors are told"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      await page.getByRole("button", { name: "Save", exact: true }).click();
      await page.getByText("The map is saved: map.lcmslam, 4.1 MB").waitFor();
      await page.getByRole("button", { name: "Begin anew" }).click();
      assert.equal(heard(server, "reset").length, 0);
      await page.getByRole("button", { name: "Press again: the map is left" }).click();
      await until(() => heard(server, "reset").length === 1, "reset");
      server.refuse.set("export", "the disk is full");
      await page.getByRole("button", { name: "Export" }).click();
      await page.getByText("the disk is full").waitFor();
      await page.getByRole("button", { name: "Start a log" }).click();
      await page.getByRole("button", { name: "Stop the log" }).waitFor();
      assert.deepEqual(heard(server, "log").map(({ on }) => on), [true]);
    });
  },

  async "a log that is written is shown to whoever comes, who may stop it"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      await page.getByRole("button", { name: "Start a log" }).click();
      await page.getByRole("button", { name: "Stop the log" }).waitFor();
      await page.reload();
      await page.getByRole("button", { name: "Stop the log" }).click();
      await page.getByRole("button", { name: "Start a log" }).waitFor();
      assert.deepEqual(heard(server, "log").map(({ on }) => on), [true, false]);
    });
  },

  async "only what the server can is offered"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server, ["save"]);
      await page.getByRole("button", { name: "Save", exact: true }).waitFor();
      for (const name of ["Begin anew", "Export", "Start a log", /^Drive/, /Send the robot/]) assert.equal(await page.getByRole("button", { name }).count(), 0, String(name));
      await page.keyboard.press("x");
      await page.keyboard.press("w");
      assert.equal(heard(server, "drive").length, 0);
    });
  },

  async "following begins without falling behind a robot that drives"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      const lag = await page.evaluate(async () => {
        const { view } = window.lcmslam;
        const place = view.target.clone().set(0, 0, 0);
        view.robotAt(place, 0);
        view.setFollow(true);
        const begin = performance.now();
        while (performance.now() < begin + 1500) { // three times the flight's time
          await new Promise(requestAnimationFrame);
          place.x = (performance.now() - begin) / 1000;
          view.robotAt(place, 0);
        }
        return view.target.distanceTo(place);
      });
      assert.ok(lag < 0.01, `${lag} m behind`);
    });
  },

  async "zooming, turning and looking from above do not lose a robot that is followed"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      const place = (follow) => page.evaluate((follow) => {
        const { view } = window.lcmslam;
        view.restore({ at: [0, 0, 0], turn: [0, 0.6], far: 6, view: "free", follow: false });
        view.robotAt(view.target.clone().set(6, 0, 0), 0);
        view.setFollow(follow);
      }, follow);
      const off = (act) => page.evaluate(async (act) => {
        const { view } = window.lcmslam;
        if (act === "zoom") view.zoom(0.9); // while it flies to the robot
        else if (act === "orbit") view.orbit(0.1, 0);
        else view.show(act);
        const begin = performance.now();
        while (performance.now() < begin + 1000) await new Promise(requestAnimationFrame);
        view.robotAt(view.target.clone().set(9, 0, 0), 0);
        return [view.follow, view.target.distanceTo(view.robot.position)];
      }, act);
      for (const act of ["zoom", "orbit", "top", "front"]) {
        await place(true);
        const [follow, distance] = await off(act);
        assert.ok(follow && distance < 0.01, `${act}: ${follow}, ${distance} m beside the robot`);
      }
    });
  },

  async "two fingers zoom while the robot is followed"(browser) {
    await withPage(browser, { ...still, context: { hasTouch: true } }, async (page, server, context) => {
      await furnish(page, server);
      await page.keyboard.press("o");
      const session = await context.newCDPSession(page);
      const touch = (type, ...places) => session.send("Input.dispatchTouchEvent", { type, touchPoints: places.map(([x, y], id) => ({ x, y, id })) });
      const view = () => page.evaluate(() => ({ follow: window.lcmslam.view.follow, distance: window.lcmslam.view.distance }));
      const { distance } = await view();
      await touch("touchStart", [450, 400], [550, 400]);
      for (let i = 1; i <= 5; ++i) await touch("touchMove", [450 - 10 * i, 400], [550 + 10 * i, 400]);
      await until(async () => (await view()).distance < 0.8 * distance, "a nearer view");
      assert.ok((await view()).follow, "it follows still");
      for (let i = 1; i <= 3; ++i) await touch("touchMove", [400, 400 + 20 * i], [600, 400 + 20 * i]);
      await touch("touchEnd");
      await until(async () => !(await view()).follow, "moving the view ends following");
    });
  },

  async "a map of landmarks alone, and its path, are looked at whole"(browser) {
    await withPage(browser, still, async (page, server) => {
      const landmark = (x, y) => Buffer.concat([floats([x, y, 0, 1e-4, 0, 0, 1e-4, 0, 1e-4]), Buffer.alloc(8)]);
      server.put(encode({ channel: "landmarks", key: "0", n: 1 }, landmark(20, 5)));
      server.put(encode({ channel: "landmarks", key: "1", n: 1 }, landmark(40, 5)));
      server.put(encode({ channel: "path", key: "fastslam/0" }, floats([30, -25, 0, 30, 0, 0])));
      server.put(encode({ channel: "path", key: "odometry/0" }, floats([-500, 0, 0, 500, 0, 0]))); // not shown
      await until(async () => (await figures(page)).landmarks === 2, "landmarks");
      await page.keyboard.press("v");
      const view = () => page.evaluate(() => ({ target: window.lcmslam.view.target.toArray(), distance: window.lcmslam.view.distance }));
      await until(async () => (await view()).distance > 20, "a view from afar");
      await until(async () => Math.hypot((await view()).target[0] - 30, (await view()).target[1] + 10) < 0.1, "the middle of all");
      assert.ok((await view()).distance < 120, JSON.stringify(await view()));
    });
  },

  async "a picture is saved"(browser) {
    await withPage(browser, still, async (page, server) => {
      await furnish(page, server);
      const download = page.waitForEvent("download");
      await page.keyboard.press("p");
      assert.match((await download).suggestedFilename(), /^lcmslam-.*\.png$/);
    });
  },
};
