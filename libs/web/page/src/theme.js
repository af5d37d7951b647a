// Dark or light, as the system says until somebody chooses. Colours of Okabe and Ito, which the colour-blind tell apart.
import { Color } from "three";
import { recall, remember } from "./memory.js";

const listeners = [];
const system = matchMedia("(prefers-color-scheme: light)");

let chosen = recall("theme");

export function theme() {
  return chosen ?? (system.matches ? "light" : "dark");
}

export function toggleTheme() {
  chosen = theme() === "dark" ? "light" : "dark";
  remember("theme", chosen);
  apply();
}

/** Calls now and at each change. */
export function onTheme(listener) {
  listeners.push(listener);
  listener(colours());
}

function apply() {
  document.documentElement.dataset.theme = theme();
  for (const listener of listeners) listener(colours());
}

export function startTheme() {
  system.addEventListener("change", apply);
  apply();
}

/** A colour of page.css as three.js has it. */
function colours() {
  const style = getComputedStyle(document.documentElement);
  const of = (name) => new Color(style.getPropertyValue(`--${name}`).trim());
  return {
    scene: of("scene"),
    line: of("scene-line"),
    ink: of("ink"),
    accent: of("accent"),
    icp: of("icp"),
    fastslam: of("fastslam"),
    odometry: of("odometry"),
    truth: of("truth"),
    loop: of("loop"),
    bad: of("bad"),
  };
}
