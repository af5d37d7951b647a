// An operator's page behind a bridge: the robot's graph, a broker, a bad link between them, and at the other end a map server
// with its page, on a bus of its own.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { badLink } from "./bad_link.mjs";
import { watchBoard } from "./board_watch.mjs";
import { figures, freePort, until } from "./browser.mjs";
import { Graph, open, slow } from "./live_graph.mjs";

const watched = 15_000; // ms

class Broker {
  async start() {
    this.port = await freePort();
    this.folder = mkdtempSync(join(tmpdir(), "lcmslam-broker-"));
    const configuration = join(this.folder, "mosquitto.conf");
    // In a namespace of its own this user looks like root, but may not become another.
    writeFileSync(configuration, `user root\nlistener ${this.port} 127.0.0.1\nallow_anonymous true\nmax_queued_messages 100000\n`);
    this.program = spawn("mosquitto", ["-c", configuration], { stdio: "ignore" });
    return this;
  }
  stop() {
    this.program.kill();
    rmSync(this.folder, { recursive: true, force: true });
  }
}

const robotGraph = (root, bridgePort) => (port) => `include: ${root}/config/demo.yaml
launch: {processes: [camera, surf, odometry, fastslam, icp, map-server, bridge]}
camera: {simulation: {scene: ${root}/config/scenes/kitchen.yaml, laps: 9}}
bridge: {host: 127.0.0.1, port: ${bridgePort}, robot: dora, receive: [COMMAND, MAP_REQUEST]}
map-server: {page: {web: {port: ${port}}}}
`;
const operatorGraph = (root, bridgePort) => (port) => `include: ${root}/config/operator.yaml
launch: {robot: dora}
bridge: {host: 127.0.0.1, port: ${bridgePort}, robot: dora}
map-server: {page: {web: {port: ${port}}}}
`;
/** Two machines' buses. */
const otherBus = { LCM_DEFAULT_URL: `udpm://239.255.76.68:${30000 + Math.floor(10000 * Math.random())}?ttl=0&recv_buf_size=2097152` };

/** Places of both mappers a second at the operator's page, and how much later they are there than at the robot's: ms, ascending. */
async function watchPoses(robot, operator) {
  const there = [], ages = [], places = { icp: new Set(), fastslam: new Set() };
  const near = watchBoard(robot.address, robot.port, ({ channel, utime }) => channel === "poses" && there.push([utime, performance.now()]));
  near.on("open", () => near.send(JSON.stringify({ want: [] })));
  const far = watchBoard(operator.address, operator.port, ({ channel, utime, ...poses }) => {
    if (channel !== "poses") return;
    for (const [mapper, seen] of Object.entries(places)) if (poses[mapper]) seen.add(JSON.stringify(poses[mapper].T));
    const first = there.find(([known]) => known >= utime); // the robot's page knows wheels, too, and is ahead by them
    if (first) ages.push(performance.now() - first[1]);
  });
  await until(() => ages.length > 0, "a pose at the operator's", slow);
  ages.length = 0;
  for (const seen of Object.values(places)) seen.clear();
  const begin = performance.now();
  await until(() => performance.now() - begin > watched, "the time to watch", 2 * watched);
  const seconds = (performance.now() - begin) / 1000;
  near.close();
  far.close();
  return { rates: Object.values(places).map((seen) => seen.size / seconds), ages: ages.sort((a, b) => a - b) };
}

export const tests = {
  async "an operator sees the robot and its maps over a bad link, as they are now"(browser, { picture, measured, programs, root }) {
    const broker = await new Broker().start();
    const link = await badLink({ port: broker.port, megabits: 2, delay: 200, loss: 0.05 });
    const robot = new Graph(), operator = new Graph();
    try {
      await operator.start(programs, operatorGraph(root, broker.port), otherBus);
      await robot.start(programs, robotGraph(root, link.port));
      const { page, errors, close } = await open(browser, operator);
      const seen = await until(async () => {
        const now = await figures(page);
        return now?.points > 0 && now.landmarks > 0 ? now : null;
      }, "both maps", slow);

      const { rates, ages } = await watchPoses(robot, operator);
      const [median, late] = [0.5, 0.95].map((share) => ages[Math.floor(share * ages.length)]);
      measured("poses at the operator's page", `${rates.map((rate) => rate.toFixed(1)).join(" and ")} a second (icp, fastslam), ${median?.toFixed(0)} ms old, 95 % within ${late?.toFixed(0)} ms; ` +
        `${link.lost} packets were lost`);
      assert.ok(Math.min(...rates) > 3, `${rates} poses a second`); // of 5
      assert.ok(median < 1000 && late < 2000, `poses are ${median} ms old, 95 % within ${late} ms`);
      assert.ok(link.lost > 0, "the link was good");

      await until(async () => {
        const now = await figures(page);
        return now.landmarks > seen.landmarks && now.keyframes > seen.keyframes;
      }, "both maps grow", slow);
      await page.getByText("Waiting for the camera's first image.").waitFor({ state: "hidden", timeout: slow });
      await picture(page, "bridge");
      assert.deepEqual(errors, [], "the page's console");
      await close();
    } finally {
      await robot.stop();
      await operator.stop();
      link.close();
      broker.stop();
    }
  },
};
