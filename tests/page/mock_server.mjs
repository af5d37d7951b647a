// A map server without a map server: speaks docs/LIVE_PAGE.md with a kitchen that is made up.
//   node mock_server.mjs [PORT]   to look at the page by hand
import { createServer } from "node:http";
import { createReadStream, existsSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, extname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { Story } from "./drive_story.mjs";
import { encode, inParts } from "./messages.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const root = resolve(here, "../..");
const types = { ".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };
// As libs/web has it, but for styles: the page needs none that is written into it.
const policy = "default-src 'self'; connect-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/** Where npm put ws and playwright-core; tests/page/CMakeLists.txt says where. */
export const modules = process.env.LCMSLAM_PAGE_MODULES ?? join(root, "libs/web/page");
export const require = createRequire(join(modules, "package.json"));

export class MockServer {
  /** @param {{token?: string, page?: string, pace?: number, tell?: boolean}} options `pace`: of the story, 1 is real time */
  constructor({ token = "", page = join(root, "libs/web/page/dist"), pace = 1, story = true } = {}) {
    Object.assign(this, { token, page, pace, hasStory: story });
    this.board = new Map();
    this.live = new Set();
    this.heard = []; // commands
    this.said = []; // what browsers said on /live
    this.refuse = new Map(); // do -> error
    this.isCut = false; // as over a network that went: nothing comes through, no socket closes
    this.swallowed = []; // sockets that were to be opened meanwhile
  }

  put(message) {
    const length = message.readUInt32LE(0);
    const { channel, key } = JSON.parse(message.subarray(4, 4 + length));
    const name = `${channel} ${key}`;
    this.board.delete(name);
    this.board.set(name, message);
    for (const client of this.live) client.fresh.add(name);
    this.#flush();
  }

  takeAway(message) {
    const { channel, key } = JSON.parse(message.subarray(4, 4 + message.readUInt32LE(0)));
    this.board.delete(`${channel} ${key}`);
    for (const { socket } of this.live) socket.send(message);
  }

  async listen(port = 0) {
    const { WebSocketServer } = require("ws");
    this.http = createServer((request, response) => this.#serve(request, response));
    const sockets = new WebSocketServer({ noServer: true, perMessageDeflate: false });
    this.http.on("upgrade", (request, socket, head) => {
      if (this.isCut) return this.swallowed.push(socket);
      if (!this.#mayEnter(request)) return socket.end("HTTP/1.1 401 Unauthorized\r\nConnection: close\r\n\r\n");
      sockets.handleUpgrade(request, socket, head, (one) => this.#meet(one, new URL(request.url, "http://here")));
    });
    await new Promise((done) => this.http.listen(port, "127.0.0.1", done));
    this.port = this.http.address().port;
    if (this.hasStory && !this.story) this.story = new Story((message) => this.put(message), join(root, "logs/kitchen_drive.lcmlog"));
    if (this.story) this.timer = setInterval(() => this.story.step(), 100 / this.pace);
    return this;
  }

  get address() {
    return `http://127.0.0.1:${this.port}/`;
  }

  /** All connections are cut and none is taken; listen(port) again brings the server back. */
  async close() {
    clearInterval(this.timer);
    for (const socket of [...this.live].map((client) => client.socket).concat([...(this.commands ?? [])])) socket.terminate();
    this.live.clear();
    for (const socket of this.swallowed) socket.destroy(); // close() would wait for them for ever
    this.http.closeAllConnections();
    await new Promise((done) => this.http.close(done));
  }

  #mayEnter(request) {
    if (this.token === "") return true;
    return (request.headers.cookie ?? "").includes(`lcmslam=${this.token}`);
  }

  #serve(request, response) {
    const { pathname, searchParams } = new URL(request.url, "http://here");
    const headers = { "Content-Security-Policy": policy, "X-Content-Type-Options": "nosniff", "Cache-Control": "no-store" };
    if (this.token !== "" && searchParams.get("token") === this.token) headers["Set-Cookie"] = `lcmslam=${this.token}; HttpOnly; SameSite=Strict; Path=/`;
    else if (!this.#mayEnter(request)) {
      response.writeHead(401, { ...headers, "Content-Type": "text/plain; charset=utf-8" });
      return response.end("This page wants the token that map-server printed when it began: ?token=...\n");
    }
    const file = join(this.page, pathname === "/" ? "index.html" : pathname.slice(1));
    if (!file.startsWith(this.page) || !existsSync(file)) {
      response.writeHead(404, headers);
      return response.end();
    }
    response.writeHead(200, { ...headers, "Content-Type": types[extname(file)] ?? "application/octet-stream" });
    createReadStream(file).pipe(response);
  }

  #meet(socket, { pathname, searchParams }) {
    if (pathname === "/command") {
      this.commands = (this.commands ?? new Set()).add(socket);
      socket.on("message", (data) => this.#answer(socket, JSON.parse(data)));
      return;
    }
    const client = { socket, fresh: new Set(this.board.keys()), want: null, sent: 0, got: 0, parts: searchParams.get("parts") === "1" };
    this.live.add(client);
    socket.on("close", () => this.live.delete(client));
    socket.on("message", (data) => {
      const said = JSON.parse(data);
      this.said.push(said);
      if (said.got !== undefined) client.got = said.got;
      if (said.want) client.want = said.want;
      this.#flush();
    });
    this.#flush();
  }

  /** Sends what each browser lacks, as long as no more than 256 kB are under way. */
  #flush() {
    if (this.isCut) return;
    const bulk = ["points", "mesh", "landmarks", "image", "particles", "grid", "planes", "objects"];
    for (const client of this.live)
      for (const name of client.fresh) {
        if (client.sent - client.got > 256_000) break;
        const channel = name.split(" ", 1)[0];
        if (client.want && bulk.includes(channel) && !client.want.includes(channel)) continue;
        client.fresh.delete(name);
        const message = this.board.get(name);
        if (!message) continue;
        for (const part of client.parts ? inParts(message) : [message]) {
          client.sent += part.length;
          client.socket.send(part);
        }
      }
  }

  #answer(socket, command) {
    if (this.isCut) return;
    const { id, do: what } = command;
    this.heard.push({ ...command, when: performance.now() });
    const reply = (members) => socket.send(JSON.stringify({ id, ...members }));
    if (this.refuse.has(what)) return reply({ ok: false, error: this.refuse.get(what) });
    const answers = {
      save: () => ({ words: "The map is saved: map.lcmslam, 4.1 MB" }),
      reset: () => ({ words: "Both mappers begin a new map" }),
      export: () => ({ files: ["icp_mesh.ply", "icp_grid.pgm"] }),
      log: () => {
        this.put(encode({ channel: "log", key: "", on: command.on, file: "out/2026-11-23.lcmlog" }));
        return { file: "out/2026-11-23.lcmlog" };
      },
      go_to: () => ({ words: "The goal was published on GOAL" }),
      query: () => ({ content: "application/json; frame=map; map_version=1", answer: answerTo(command.question) }),
    };
    reply({ ok: true, ...(answers[what]?.() ?? {}) });
  }
}

function answerTo({ ask, points }) {
  if (ask === "distance") return { distances: points.map(() => 0.42), gradients: points.map(() => [0, 0, 1]), truncation: 2 };
  if (ask === "space") return { states: points.map(([, , z]) => (z > 1.95 ? "occupied" : "free")) };
  return {};
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const server = await new MockServer().listen(Number(process.argv[2] ?? 8642));
  console.log(server.address);
}
