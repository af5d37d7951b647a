// The live page of map-server (docs/LIVE_PAGE.md): puts its parts together.
import { Board } from "./board.js";
import { View } from "./camera.js";
import { notifier, ToolCard } from "./card.js";
import { Connection } from "./connection.js";
import { el } from "./dom.js";
import { emptyState } from "./empty.js";
import { Gestures } from "./gestures.js";
import { Keys } from "./keys.js";
import { carriedItems } from "./offline.js";
import { Column } from "./panels/column.js";
import { imagePanel } from "./panels/image.js";
import { layersPanel } from "./panels/layers.js";
import { noticesPanel } from "./panels/notices.js";
import { posesPanel } from "./panels/poses.js";
import { processesPanel } from "./panels/processes.js";
import { registrationPanel } from "./panels/registration.js";
import { sessionsPanel } from "./panels/sessions.js";
import { Strip } from "./panels/strip.js";
import { timeSlider } from "./panels/time_slider.js";
import { makeScene } from "./scene.js";
import { AddressKeeper, readAddress } from "./share.js";
import { Stage } from "./stage.js";
import { Switches } from "./switches.js";
import { startTheme } from "./theme.js";
import { toolBar } from "./tools/bar.js";
import { Drive } from "./tools/drive.js";
import { GoTo } from "./tools/go_to.js";
import { Hand } from "./tools/hand.js";
import { Inspect } from "./tools/inspect.js";
import { Measure } from "./tools/measure.js";
import { Picker } from "./tools/pick.js";
import { upkeepPanel } from "./tools/upkeep.js";
import { Labels } from "./views/labels.js";

const asked = readAddress();
if (new URLSearchParams(location.search).has("token"))
  history.replaceState(null, "", location.pathname + location.hash); // the cookie holds it now; nobody reads it over a shoulder

startTheme();
const canvas = el("canvas", { tabindex: 0, "aria-label": "The map in three dimensions. Arrows turn it, plus and minus zoom, question mark tells all keys." });
const labelHost = el("div", { class: "labels", "aria-hidden": "true" });
const scene = el("div", { class: "scene" }, canvas, labelHost);
const strip = el("header", { class: "strip" });
const foot = el("div", { class: "foot" });
const overlay = el("div", { class: "overlay" }, foot);
const columnHost = el("aside", { class: "column", "aria-label": "Panels" });
document.getElementById("page").append(scene, strip, overlay, columnHost);

const board = new Board();
const switches = new Switches();
for (const name of asked.on) switches.set(name, true);
for (const name of asked.off) switches.set(name, false);
const stage = makeStage();
const view = new View(stage);
const labels = new Labels(stage, labelHost);
const views = makeScene({ stage, board, switches, view, labels });
view.restore(asked);

const notify = notifier(foot);
const card = new ToolCard(foot);
const can = (what) => Boolean(board.get("about")?.header.can?.includes(what));
const carried = readCarried();
let connection = null;
const command = {
  do: (...words) => (connection ? connection.commands.do(...words) : Promise.reject(new Error("this page is a file"))),
  ask: (question) => (connection ? connection.commands.ask(question) : Promise.reject(new Error("this page is a file"))),
};
const robot = () => views.robot.pose;
const parts = { stage, picker: new Picker(stage, views, () => view.reach()), labels, planes: views.planes, card, command, notify, can, robot, host: foot,
  robotHeight: () => board.get("about")?.header.robot?.height ?? 0.6 };
const hand = new Hand({ inspect: new Inspect(parts), measure: new Measure(parts), goto: new GoTo(parts), drive: new Drive(parts) });
new Gestures(canvas, view, hand);

const address = new AddressKeeper(view, switches);
for (const event of ["moved", "changed"]) view.addEventListener(event, () => address.later());
switches.on(["*"], () => address.later());
async function share() {
  address.write();
  try {
    await navigator.clipboard.writeText(location.href);
    notify("good", "The address of this view is copied.");
  } catch {
    notify("good", "The address bar holds this view now.");
  }
}

const keys = new Keys({ stage, view, switches, hand, share });
const health = new Strip(strip, board, { help: () => keys.help() });
toolBar(overlay, { stage, view, hand, board, share });
const column = new Column(columnHost, makeRoom);
health.state.addEventListener("click", () => column.open("health"));
function makeRoom() {
  stage.setInset({ top: strip.offsetHeight, ...column.covers });
}
addEventListener("resize", makeRoom);
layersPanel(column, switches);
imagePanel(column, board);
posesPanel(column, board);
registrationPanel(column, board);
sessionsPanel(column, board);
const figures = () => ({ keyframes: views.graph.keyframes, loops: views.graph.loops, points: views.points.resident, triangles: views.mesh.triangles, landmarks: views.landmarks.total });
upkeepPanel(column, board, command, notify, figures);
processesPanel(column, board);
noticesPanel(column, board);
makeRoom();
timeSlider(foot, board, (members) => command.do("play", members).catch((error) => notify("bad", error.message)));
emptyState(overlay, board);

if (carried) {
  health.setConnection("file");
  for (const item of carried) {
    if (item.channel === "about") item.header.can = []; // nobody is there to ask
    board.put(item);
  }
  if (view.untouched) view.keepAll();
  else if (!asked.at) view.fitAll();
} else connection = new Connection({ board, strip: health, stage, view, switches });

/** What tests and benchmarks read. */
window.lcmslam = { figures: () => ({ ...figures(), drawn: views.points.drawn, frames: stage.frames, frameTime: stage.frameTime, bytes: connection?.stream.bytes ?? 0 }), view, views, stage, board, switches };

function makeStage() {
  try {
    return new Stage(canvas);
  } catch (error) {
    document.body.append(el("p", { class: "nothing", role: "alert", text: error.message }));
    throw error;
  }
}

function readCarried() {
  try {
    return carriedItems();
  } catch (error) {
    notify("bad", `This file cannot be read: ${error.message}`);
    return [];
  }
}
