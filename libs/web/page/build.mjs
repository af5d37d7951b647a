// Bundles the page: `node build.mjs [FOLDER]` writes index.html, page.js, page.css and icon.svg into dist/ or FOLDER. Two
// builds of the same sources give the same bytes. tests/page compares dist/, which is committed, with a fresh build.
import { copyFile, mkdir, readFile } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const folder = resolve(process.argv[2] ?? join(here, "dist"));
const largest = 1_000_000; // bytes, compressed

await mkdir(folder, { recursive: true });
const common = { absWorkingDir: here, outdir: folder, bundle: true, minify: true, charset: "utf8", logLevel: "warning" };
await build({ ...common, entryPoints: { page: "src/main.js" }, format: "iife", target: ["es2022"], legalComments: "eof" });
await build({ ...common, entryPoints: ["src/page.css"], target: ["chrome110", "firefox115", "safari16"] });
for (const name of ["index.html", "icon.svg"]) await copyFile(join(here, name), join(folder, name));

const script = await readFile(join(folder, "page.js"), "utf8");
// `export --html` puts the script between tags: these would end or confuse them.
for (const word of ["</script", "<!--"])
  if (script.toLowerCase().includes(word)) throw new Error(`page.js holds ${word}, and could not stand inside a page`);
const bytes = gzipSync(script).length + gzipSync(await readFile(join(folder, "page.css"))).length;
if (bytes >= largest) throw new Error(`the bundle has ${bytes} bytes compressed, must be below ${largest}`);
console.log(`${folder}: ${Math.round(bytes / 1000)} kB compressed`);
