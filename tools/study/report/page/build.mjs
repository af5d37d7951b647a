// Bundles the report's page: `node build.mjs [FOLDER]` writes index.html, report.js and report.css into dist/ or FOLDER. Two
// builds of the same sources give the same bytes. tests/study_page compares dist/, which is committed, with a fresh build.
import { copyFile, mkdir, readFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const folder = resolve(process.argv[2] ?? join(here, "dist"));

await mkdir(folder, { recursive: true });
const common = { absWorkingDir: here, outdir: folder, bundle: true, minify: true, charset: "utf8", logLevel: "warning" };
await build({ ...common, entryPoints: { report: "src/main.js" }, format: "iife", target: ["es2022"], legalComments: "eof" });
await build({ ...common, entryPoints: ["src/report.css"], target: ["chrome110", "firefox115", "safari16"] });
await copyFile(join(here, "index.html"), join(folder, "index.html"));

const script = await readFile(join(folder, "report.js"), "utf8");
if (script.includes("<!--")) throw new Error("report.js holds <!--, and could not stand inside a page");
console.log(`${folder}: ${Math.round(script.length / 1000)} kB`);
