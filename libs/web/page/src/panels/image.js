// The camera's image with the features that FastSLAM knows again (thesis, figure 2.3).
import { el, iconButton } from "../dom.js";
import { bytes } from "../messages.js";

const old = 3; // s
const accepted = 0;
const unused = 1;
const rejected = 2;
const colours = ["#009e73", "#f0e442", "#d55e00", "#56b4e9"]; // of Okabe and Ito, as in the legend
const outcomes = ["known", "unused", "rejected", "new"];

export function imagePanel(column, board) {
  const { card, body, setNote, isSeen, show } = column.card("camera", "camera", "Camera");
  const canvas = el("canvas", { role: "img", "aria-label": "the camera's image with its features", width: 4, height: 3 });
  const empty = el("p", { class: "empty", text: "Waiting for the camera's first image." });
  const grow = iconButton("grow", "Larger, with the landmarks' ids", () => enlarge(), { class: "tool over", "aria-pressed": "false" });
  const legend = el("div", { class: "legend" }, ...outcomes.map((text, i) => el("span", { class: `outcome o${i}`, text })));
  const frame = el("div", { class: "image", hidden: true }, canvas, grow);
  legend.hidden = true;
  body.append(empty, frame, legend);
  let newest = null;
  let busy = false;

  function enlarge() {
    const large = card.classList.toggle("large");
    grow.setAttribute("aria-pressed", String(large));
    draw();
  }

  async function draw() {
    if (busy || !newest || !isSeen()) return;
    busy = true;
    const item = newest;
    try {
      const picture = await createImageBitmap(new Blob([bytes(item)], { type: "image/jpeg" }));
      paint(canvas, picture, item.header, card.classList.contains("large"));
      picture.close();
    } catch (error) {
      setNote("not readable");
    }
    busy = false;
    if (newest !== item) draw();
  }

  card.addEventListener("unfold", draw);
  new ResizeObserver(draw).observe(frame);
  board.on("about", (item) => show(item?.header.source !== "file" || newest));
  board.on("image", (item) => {
    newest = item;
    if (item) show(true);
    empty.hidden = Boolean(item);
    frame.hidden = legend.hidden = !item;
    note();
    draw();
  });
  board.on("poses", note); // a picture that no longer comes says how old it is
  function note() {
    const tracks = newest?.header.tracks ?? [];
    const seen = tracks.filter(([, , , outcome]) => outcome === accepted).length;
    const age = ((board.get("poses")?.header.utime ?? 0) - (newest?.header.utime ?? 0)) / 1e6;
    const words = age > old ? `${age.toFixed(0)} s old` : `${seen} of ${tracks.length} features seen again`;
    setNote(newest ? words : "");
  }
  addEventListener("keydown", (event) => event.key === "Escape" && card.classList.contains("large") && enlarge());
}

function paint(canvas, picture, { width, height, tracks = [] }, ids) {
  const shown = canvas.clientWidth || 320;
  const ratio = Math.min(devicePixelRatio, 2);
  canvas.width = Math.round(shown * ratio);
  canvas.height = Math.round((canvas.width * height) / width);
  const context = canvas.getContext("2d");
  context.drawImage(picture, 0, 0, canvas.width, canvas.height);
  const scale = canvas.width / width;
  context.font = `${12 * ratio}px system-ui, sans-serif`;
  for (const [x, y, landmark, outcome] of tracks) {
    context.lineWidth = 1.5 * ratio;
    context.strokeStyle = context.fillStyle = colours[outcome] ?? colours[unused];
    mark(context, x * scale, y * scale, 3 * ratio, outcome);
    if (ids && outcome !== rejected) {
      context.strokeStyle = "rgba(0, 0, 0, 0.75)";
      context.fillStyle = "#fff";
      context.lineWidth = 3 * ratio;
      context.strokeText(landmark, x * scale + 6 * ratio, y * scale - 4 * ratio);
      context.fillText(landmark, x * scale + 6 * ratio, y * scale - 4 * ratio);
    }
  }
}

/** A disc, a ring, a cross, a plus: told apart without colours. */
function mark(context, x, y, r, outcome) {
  context.beginPath();
  if (outcome === rejected) {
    context.moveTo(x - r, y - r);
    context.lineTo(x + r, y + r);
    context.moveTo(x - r, y + r);
    context.lineTo(x + r, y - r);
  } else if (outcome > rejected) {
    context.moveTo(x - r, y);
    context.lineTo(x + r, y);
    context.moveTo(x, y - r);
    context.lineTo(x, y + r);
  } else context.arc(x, y, r, 0, 2 * Math.PI);
  if (outcome === accepted) context.fill();
  else context.stroke();
}
