// What a column of free, occupied and unknown space says of the room above a point.
import { length } from "../format.js";

/** `states` at `step`, 2 `step`, ... m above the point, the first of which may lie in its own surface. In words. */
export function headroom(states, step) {
  const end = states.findIndex((state, i) => state === "unknown" || (i > 0 && state === "occupied"));
  if (end < 0) return `${(step * states.length).toFixed(1)} m or more`;
  if (states[end] === "occupied") return length(step * (end + 1));
  return end === 0 ? "not known" : `${length(step * end)}, then not known`;
}
