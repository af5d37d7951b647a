// The time of a log: play, pause, speed and a slider.
import { el, icon } from "../dom.js";
import { clock, duration } from "../format.js";

const speeds = [0.5, 1, 2, 4];

/** @param play sends a command: {playing, speed, at} */
export function timeSlider(host, board, play) {
  let time = null;
  let held = false;
  const toggle = el("button", { type: "button", class: "tool", on: { click: () => play({ playing: !time.playing }) } });
  const slider = el("input", { type: "range", min: 0, max: 1000, value: 0, "aria-label": "Time of the log" });
  const now = el("span", { class: "now" });
  const speed = el("button", { type: "button", class: "chip", on: { click: () => play({ speed: next(time.speed) }) } });
  const bar = el("div", { class: "time", role: "group", "aria-label": "The log's time", hidden: true }, toggle, slider, now, speed);
  host.append(bar);
  slider.addEventListener("input", () => {
    held = true;
    write();
  });
  slider.addEventListener("change", () => {
    held = false;
    play({ at: at() });
  });
  // Dragged back to where it was it has not changed.
  for (const end of ["pointerup", "pointercancel"]) addEventListener(end, () => setTimeout(() => (held = false))); // after "change"
  slider.addEventListener("blur", () => (held = false));
  const at = () => Math.round(time.begin + (slider.value / 1000) * (time.end - time.begin));
  function write() {
    const utime = held ? at() : time.now;
    now.textContent = `${duration((utime - time.begin) / 1e6)} of ${duration((time.end - time.begin) / 1e6)}`;
    slider.setAttribute("aria-valuetext", `${now.textContent}, ${clock(utime)}`);
    const share = (utime - time.begin) / Math.max(1, time.end - time.begin);
    slider.style.setProperty("--done", `${100 * share}%`);
  }
  board.on("time", (item) => {
    time = item?.header ?? null;
    bar.hidden = !time;
    if (!time) return;
    toggle.replaceChildren(icon(time.playing ? "pause" : "play"));
    toggle.setAttribute("aria-label", time.playing ? "Pause" : "Play");
    speed.textContent = `${time.speed} ×`;
    speed.setAttribute("aria-label", `Speed ${time.speed}; press for ${next(time.speed)}`);
    if (!held) slider.value = Math.round((1000 * (time.now - time.begin)) / Math.max(1, time.end - time.begin));
    write();
  });
}

function next(speed) {
  return speeds[(speeds.indexOf(speed) + 1) % speeds.length];
}
