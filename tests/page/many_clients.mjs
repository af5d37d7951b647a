// node tests/page/many_clients.mjs PROGRAMS [CLIENTS] [SILENT]: what it costs a robot to be watched. Runs the demo twice, first
// without anybody, then with CLIENTS (20) browsers of which SILENT (5) never read, and tells the frames that the mappers
// answered, what map-server took of a core, and what these clients took, who share the same cores. Run it on a bus of its own:
// unshare -Urn bash -c "ip link set lo up; ip route add 224.0.0.0/4 dev lo; node tests/page/many_clients.mjs build/release/bin"
import { spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { freePort } from "./browser.mjs";
import { Crowd } from "./crowd.mjs";

const [programs, clients = "20", staring = "5"] = process.argv.slice(2);

async function run(watchers, silent) {
  const folder = mkdtempSync(join(tmpdir(), "lcmslam-watched-"));
  const port = await freePort();
  const demo = spawn(resolve(programs, "lcmslam"), ["demo", "--out", folder, "--set", `map-server.page.web.port=${port}`], { stdio: "ignore" });
  const crowd = new Crowd(port, { watchers, silent });
  const before = process.cpuUsage();
  const exit = await new Promise((done) => demo.once("exit", done));
  crowd.leave();
  const own = process.cpuUsage(before);
  const { paths, processes, timing: { wall_seconds: seconds }, frames } = JSON.parse(readFileSync(join(folder, "summary.json"), "utf8"));
  rmSync(folder, { recursive: true, force: true });
  const server = processes["map-server"].cpu_s / seconds;
  console.log(`${watchers + silent} clients: demo's exit code ${exit}; of ${frames} frames icp answered ${paths.icp.poses}, ` +
    `fastslam ${paths.fastslam.poses}; map-server ${(100 * server).toFixed(1)} % of a core, the clients ` +
    `${((own.user + own.system) / 1e4 / seconds).toFixed(1)} %; ${(crowd.bytes / 1e6).toFixed(0)} MB in ${crowd.messages} messages, ${crowd.stared} stared`);
  return server;
}

const alone = await run(0, 0);
const watched = await run(Number(clients) - Number(staring), Number(staring));
console.log(`one client: ${(100 * (watched - alone) / Number(clients)).toFixed(2)} % of a core`);
process.exit(0);
