// What read_export.js and write_mcap.js share. Exits with 77 where npm's packages are missing.
"use strict";
const childProcess = require("child_process");
const fs = require("fs");

function load() {
  try {
    return {
      fs,
      core: require("@mcap/core"),
      rosmsg: require("@foxglove/rosmsg"),
      rosmsg1: require("@foxglove/rosmsg-serialization"),
      rosmsg2: require("@foxglove/rosmsg2-serialization"),
      common: require("@foxglove/rosmsg-msgs-common"),
      zstd: require("@foxglove/wasm-zstd"),
      lz4: require("@foxglove/wasm-lz4"),
    };
  } catch (error) {
    console.log("skipped: no @mcap/core or @foxglove/rosmsg; ./lcmslam test installs them with npm");
    process.exit(77);
  }
}

async function decompressHandlers() {
  const { zstd, lz4 } = load();
  await zstd.isLoaded;
  await lz4.isLoaded;
  return {
    zstd: (bytes, size) => zstd.decompress(bytes, Number(size)),
    lz4: (bytes, size) => lz4(bytes, Number(size)),
  };
}

// npm has no compressor of LZ4's frames here: Debian's lz4.
async function compressor(compression) {
  const { zstd } = load();
  await zstd.isLoaded;
  const pack = {
    zstd: (bytes) => zstd.compress(bytes),
    lz4: (bytes) => childProcess.execFileSync("lz4", ["-c", "-q"], { input: bytes, maxBuffer: 1 << 30 }),
  }[compression];
  return pack && ((bytes) => ({ compression, compressedData: pack(bytes) }));
}

async function openFile(file) {
  const bytes = fs.readFileSync(file);
  return {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => new Uint8Array(bytes.subarray(Number(offset), Number(offset + size))),
  };
}

module.exports = { compressor, decompressHandlers, load, openFile };
