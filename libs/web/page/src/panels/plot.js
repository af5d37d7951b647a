// A small plot: lines over a common axis, the highest value and the unit written beside it.
import { el, svg } from "../dom.js";

const [wide, high] = [300, 84];

export class Plot {
  /** @param {string} label what it shows, for who cannot see it */
  constructor(label, format) {
    this.format = format;
    this.picture = svg("svg", { viewBox: `0 0 ${wide} ${high}`, preserveAspectRatio: "none", class: "plot", role: "img", "aria-label": label });
    this.top = el("span", { class: "top" });
    this.left = el("span", { class: "left" });
    this.right = el("span", { class: "right" });
    this.element = el("div", { class: "plot-frame" }, this.picture, this.top, this.left, this.right);
  }

  /**
   * @param {{name: string, points: number[][]}[]} lines x and y; `name` is the class that colours it
   * @param {string[]} ends what stands below the axis at its begin and end
   * @param {number[]} span x there; left out: where the lines begin and end
   */
  draw(lines, ends = ["", ""], span = null) {
    const all = lines.flatMap(({ points }) => points);
    const highest = Math.max(...all.map(([, y]) => y), 1e-9);
    const [first, last] = span ?? [Math.min(...all.map(([x]) => x)), Math.max(...all.map(([x]) => x))];
    const place = ([x, y]) => `${(((x - first) / Math.max(last - first, 1e-9)) * wide).toFixed(1)} ${(high - 1 - (y / highest) * (high - 6)).toFixed(1)}`;
    this.picture.replaceChildren(
      svg("path", { class: "axis", d: `M0 ${high - 0.5}H${wide}` }),
      ...lines.filter(({ points }) => points.length > 1).map(({ name, points }) => svg("path", { class: name, d: `M${points.map(place).join("L")}` })),
    );
    this.top.textContent = all.length ? this.format(highest) : "";
    [this.left.textContent, this.right.textContent] = ends;
  }
}
