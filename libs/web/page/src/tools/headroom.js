// What free, occupied and unknown space say of the room above a point, and around a place.
import { length } from "../format.js";

const ceiling = 2.5; // m above the point up to which is asked
const skin = 0.1; // m above the point within which its own surface, measured twice, may lie
const step = 0.02; // m; less than a cell of the occupancy grid, so that no thin table top is stepped over

/** The places above one that are to be asked about, `step` apart. */
export function columnAbove({ x, y, z }) {
  return Array.from({ length: Math.round(ceiling / step) }, (_, i) => [x, y, z + step * (i + 1)]);
}

/** `states` of columnAbove(), in words; never more than was seen to be free. */
export function headroom(states) {
  const nearest = Math.round(skin / step);
  const above = states.lastIndexOf("occupied", nearest - 1) + 1; // its own surface
  const begin = states.indexOf("free", above);
  if (begin < 0 || begin > nearest) return states[above] === "occupied" ? "nothing" : "not known";
  const end = states.findIndex((state, i) => i > begin && state !== "free");
  if (end < 0) return `${(step * states.length).toFixed(1)} m or more`;
  const free = length(step * end);
  return states[end] === "occupied" ? free : `${free}, then not known`;
}

/** The distance to the nearest obstacle in words: distances end at `truncation`, and nobody knows of them where nobody has seen. */
export function clearance(distance, truncation, state) {
  if (state === "unknown") return "not known";
  return distance >= truncation ? `${length(truncation)} or more` : length(Math.max(0, distance));
}
