// validate_gltf.js FOLDER: Khronos's validator on what write_exports wrote there. NODE_PATH leads to it.
"use strict";
const fs = require("fs");
const path = require("path");

const skipped = 77;
let validator;
try {
  validator = require("gltf-validator");
} catch (error) {
  console.log("skipped: no gltf-validator; ./lcmslam test installs it with npm");
  process.exit(skipped);
}

async function check(file, triangles) {
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
  const { numErrors, numWarnings, messages } = report.issues;
  if (numErrors + numWarnings > 0) throw new Error(`${file}: ${JSON.stringify(messages, null, 1)}`);
  if (report.info.totalTriangleCount !== triangles)
    throw new Error(`${file}: ${report.info.totalTriangleCount} triangles, ${triangles} were written`);
}

async function main(folder) {
  const expected = JSON.parse(fs.readFileSync(path.join(folder, "expected.json")));
  await check(path.join(folder, "mesh.glb"), expected.mesh.triangles.length);
  await check(path.join(folder, "empty.glb"), 0);
}

main(process.argv[2]).catch((error) => {
  console.error(error.message);
  process.exit(1);
});
