// A graph that runs, for tests of its page.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { closeSync, mkdtempSync, openSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { freePort, rough, until, watch } from "./browser.mjs";

export const slow = 90_000; // ms: two cores also draw the page

/** Processes below the launcher, by name. */
function childrenOf(parent) {
  const all = {};
  for (const pid of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const stat = readFileSync(`/proc/${pid}/stat`, "utf8");
      if (Number(stat.slice(stat.lastIndexOf(")") + 2).split(" ")[1]) !== parent) continue;
      all[readFileSync(`/proc/${pid}/cmdline`, "utf8").split("\0")[0].split("/").pop()] = Number(pid);
    } catch {
      // it has just ended
    }
  }
  return all;
}

/** The real programs, launched with a configuration of the test's. */
export class Graph {
  /** @param configure gives the configuration (YAML) whose page is served on that port */
  async start(programs, configure, environment = {}) {
    Object.assign(this, { programs, environment });
    this.folder = mkdtempSync(join(tmpdir(), "lcmslam-page-"));
    this.port = await freePort();
    this.address = `http://127.0.0.1:${this.port}`;
    const configuration = join(this.folder, "graph.yaml");
    writeFileSync(configuration, configure(this.port));
    this.out = join(this.folder, "out");
    this.launcher = this.run("lcmslam", ["launch", configuration, "--out", this.out]);
    await until(async () => (await fetch(this.address).catch(() => null))?.ok, "the page", slow);
    return this;
  }
  run(program, words) {
    // What they say goes into a file: processes that outlive a failed test must not hold the test's own output.
    const said = openSync(join(this.folder, `${program}.txt`), "a");
    const child = spawn(join(this.programs, program), words, { stdio: ["ignore", "pipe", said], env: { ...process.env, ...this.environment } });
    closeSync(said);
    child.lines = [];
    child.stdout.on("data", (text) => child.lines.push(...text.toString().split("\n").filter(Boolean)));
    return child;
  }
  kill(name) {
    const pid = childrenOf(this.launcher.pid)[`lcmslam-${name}`];
    assert.ok(pid, `${name} runs`);
    process.kill(pid, "SIGKILL");
  }
  async stop() {
    if (!this.launcher) return;
    const children = Object.values(childrenOf(this.launcher.pid));
    const ended = new Promise((done) => this.launcher.once("exit", done));
    this.launcher.kill("SIGINT");
    await Promise.race([ended, new Promise((done) => setTimeout(done, 60_000).unref())]);
    for (const pid of [this.launcher.pid, ...children]) {
      try {
        process.kill(pid, "SIGKILL");
      } catch {
        // it had ended
      }
    }
    rmSync(this.folder, { recursive: true, force: true });
  }
}

export async function open(browser, graph) {
  const context = await browser.newContext({ viewport: { width: 1000, height: 640 }, colorScheme: "dark", ...rough });
  const page = await context.newPage();
  const errors = watch(page, graph.address);
  await page.goto(graph.address);
  return { page, errors, close: () => context.close() };
}

