// The page of a graph that runs: the real programs in the simulated kitchen, on a bus of their own.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { figures, until } from "./browser.mjs";
import { Crowd } from "./crowd.mjs";
import { Graph, open, slow } from "./live_graph.mjs";

export const tests = {
  async "a graph that runs is seen, saved, driven, and seen again after its processes die"(browser, { picture, programs, root }) {
    const graph = await new Graph().start(programs, (port) => `include: ${root}/config/demo.yaml
map-server: {page: {drive_channel: TELEOP, web: {port: ${port}}}}
`);
    const crowd = new Crowd(graph.port, { watchers: 15, silent: 5 });
    try {
      let { page, errors, close } = await open(browser, graph);
      const seen = await until(async () => {
        const now = await figures(page);
        return now?.points > 0 && now.landmarks > 0 && now.triangles > 0 ? now : null;
      }, "both maps", slow);
      await until(async () => {
        const now = await figures(page);
        return now.triangles > seen.triangles && now.landmarks > seen.landmarks; // the surface takes the points' place
      }, "both maps grow", slow);
      await picture(page, "graph");

      await page.getByRole("button", { name: "Save", exact: true }).click();
      await page.getByText("what has changed is being saved").waitFor();
      await until(() => existsSync(join(graph.out, "icp_map.ply")) && existsSync(join(graph.out, "fastslam_map.ply")), "the saved maps", slow);

      const echo = graph.run("lcmslam-tools", ["echo", "TELEOP", "--json"]);
      await page.keyboard.press("x");
      await page.keyboard.down("w");
      const speed = (line) => JSON.parse(line).fields.linear[0];
      await until(() => echo.lines.length > 2 && speed(echo.lines.at(-1)) > 0, "driving", slow);
      assert.deepEqual(errors, [], "the page's console");
      await close(); // the key is still held
      await until(() => speed(echo.lines.at(-1)) === 0, "a stop as the link breaks");
      echo.kill();

      assert.ok(crowd.messages > 15 && crowd.stared >= 5, `${crowd.messages} messages were read, ${crowd.stared} never read`);
      crowd.leave();

      ({ page, errors, close } = await open(browser, graph));
      await until(async () => (await figures(page))?.keyframes > 0, "the map again", slow);
      graph.kill("map-server");
      await page.getByText("The connection to the map server is lost").waitFor({ timeout: slow });
      await until(() => page.evaluate(() => document.documentElement.dataset.connection === "open"), "the page after map-server died", slow);
      await until(async () => (await figures(page)).landmarks > 0, "the map that the mappers told again", slow);
      const statuses = graph.run("lcmslam-tools", ["echo", "STATUS", "--json"]);
      await until(() => statuses.lines.some((line) => /"process":\s*"icp"/.test(line)), "STATUS of icp, which the new map-server hears, too", slow);
      statuses.kill();
      graph.kill("icp");
      await page.getByText("icp began anew").first().waitFor({ timeout: slow, state: "attached" });
      await picture(page, "graph_after_deaths");
      const others = errors.filter((error) => !/WebSocket connection|ERR_CONNECTION_(REFUSED|RESET)|ERR_INCOMPLETE_CHUNKED_ENCODING/.test(error));
      assert.deepEqual(others, [], "the page's console");
      await close();
    } finally {
      crowd.leave();
      await graph.stop();
    }
  },
};
