// node tests/page/run.mjs [--page DIST] [--out FOLDER] [--only WORDS]: drives the page in Chromium against a mock server.
// With --programs FOLDER: against the graph that these programs make (graph_test.mjs), or the one that --tests names (bridge).
// Exit code 77: there is no Chromium or no npm package here. Pictures of the page go to FOLDER.
import { existsSync, mkdirSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import { launch } from "./browser.mjs";
import { require } from "./mock_server.mjs";

const skipped = 77;
// The first is the same browser without windows, which take a third of the time.
const browsers = ["/usr/bin/chromium-headless-shell", "/usr/bin/chromium"];
const root = resolve(dirname(fileURLToPath(import.meta.url)), "../..");
const { values } = parseArgs({ options: {
  page: { type: "string", default: join(root, "libs/web/page/dist") },
  out: { type: "string", default: join(root, "build/page") },
  only: { type: "string", default: "" },
  programs: { type: "string", default: "" },
  tests: { type: "string", default: "graph" },
  chromium: { type: "string", default: browsers.find(existsSync) ?? browsers.at(-1) },
} });

function skip(why) {
  console.log(`skipped: ${why}`);
  process.exit(skipped);
}

if (!existsSync(values.chromium)) skip(`no ${values.chromium}; apt-get install chromium`);
try {
  for (const name of ["playwright-core", "ws"]) require(name);
} catch {
  skip("no playwright-core or ws; npm ci in libs/web/page");
}

mkdirSync(values.out, { recursive: true });
const tools = {
  page: resolve(values.page),
  folder: resolve(values.out),
  programs: resolve(values.programs),
  root,
  picture: (page, name) => page.screenshot({ path: join(values.out, `${name}.png`) }),
  measured: (what, figure) => console.log(`         ${what}: ${figure}`),
};
const browser = await launch(values.chromium);
let failed = 0;
for (const file of values.programs ? [values.tests] : ["parts", "live", "tools", "looks", "doors"]) {
  const { tests } = await import(`./${file}_test.mjs`);
  for (const [name, run] of Object.entries(tests)) {
    if (!`${file} ${name}`.includes(values.only)) continue;
    const begin = performance.now();
    try {
      await run(browser, tools);
      console.log(`good     ${file}: ${name} (${((performance.now() - begin) / 1000).toFixed(1)} s)`);
    } catch (error) {
      failed += 1;
      console.log(`FAILED   ${file}: ${name}\n${error.stack}`);
    }
  }
}
await browser.close();
console.log(failed === 0 ? "all good" : `${failed} failed`);
process.exit(failed === 0 ? 0 : 1);
