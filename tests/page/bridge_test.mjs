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

const mappers = ["icp", "fastslam"];

/** What a page has shown of each mapper: its different places. */
class Places {
  clear() {
    this.seen = mappers.map(() => new Set());
  }
  add(poses) {
    mappers.forEach((mapper, i) => poses[mapper] && this.seen[i].add(JSON.stringify(poses[mapper].T)));
  }
  rates(seconds) {
    return this.seen.map((places) => places.size / seconds);
  }
}

/**
 * Places a second of each mapper at the robot's page, `told`, and at the operator's, `rates`; and how much later they are there:
 * ms, ascending.
 */
async function watchPoses(robot, operator) {
  const there = [], ages = [], nearPlaces = new Places(), farPlaces = new Places();
  const clear = () => [nearPlaces, farPlaces].forEach((places) => places.clear());
  clear();
  const near = watchBoard(robot.address, robot.port, ({ channel, utime, ...poses }) => {
    if (channel !== "poses") return;
    nearPlaces.add(poses);
    there.push([utime, performance.now()]);
  });
  near.on("open", () => near.send(JSON.stringify({ want: [] })));
  const far = watchBoard(operator.address, operator.port, ({ channel, utime, ...poses }) => {
    if (channel !== "poses") return;
    farPlaces.add(poses);
    const first = there.find(([known]) => known >= utime); // the robot's page knows wheels, too, and is ahead by them
    if (first) ages.push(performance.now() - first[1]);
  });
  await until(() => ages.length > 0, "a pose at the operator's", slow);
  ages.length = 0;
  clear();
  const begin = performance.now();
  await until(() => performance.now() - begin > watched, "the time to watch", 2 * watched);
  const seconds = (performance.now() - begin) / 1000;
  near.close();
  far.close();
  return { told: nearPlaces.rates(seconds), rates: farPlaces.rates(seconds), ages: ages.sort((a, b) => a - b) };
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

      const { told, rates, ages } = await watchPoses(robot, operator);
      const [median, late] = [0.5, 0.95].map((share) => ages[Math.floor(share * ages.length)]);
      const perSecond = (some) => some.map((rate) => rate.toFixed(1)).join(" and ");
      measured("poses at the operator's page", `${perSecond(rates)} a second of the robot's ${perSecond(told)} (${mappers.join(", ")}), ${median?.toFixed(0)} ms old, 95 % within ${late?.toFixed(0)} ms; ` +
        `${link.lost} packets were lost`);
      // How many the robot's mappers tell is a matter of the machine: 5 a second at most.
      rates.forEach((rate, i) => assert.ok(told[i] > 0 && rate > 0.6 * told[i], `${mappers[i]}: ${rate} poses a second of ${told[i]}`));
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
