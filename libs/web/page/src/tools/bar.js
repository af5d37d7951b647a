// The buttons beside the map: views on one side of a phone, tools on the other.
import { el, iconButton } from "../dom.js";
import { views } from "../camera.js";
import { snapshot } from "./snapshot.js";

const tools = [
  { name: "measure", icon: "measure", label: "Measure between two points (m)" },
  { name: "goto", icon: "goto", label: "Send the robot somewhere (g)", can: "go_to" },
  { name: "drive", icon: "drive", label: "Drive (x)", can: "drive" },
];

export function toolBar(host, { stage, view, hand, board, share }) {
  const viewButtons = Object.entries(views).filter(([name]) => name !== "free").map(([name, { label, key }]) => {
    const button = iconButton(name, `${label} (${key})`, () => view.show(name));
    button.dataset.view = name;
    return button;
  });
  const fit = iconButton("free", "Show the whole map (v)", () => view.fitAll());
  const follow = iconButton("follow", "Follow the robot (o)", () => view.setFollow(!view.follow));
  const toolButtons = tools.map(({ name, icon, label }) => {
    const button = iconButton(icon, label, () => hand.take(name));
    button.dataset.tool = name;
    return button;
  });
  const left = el("div", { class: "bar views", role: "toolbar", "aria-label": "Views" }, fit, ...viewButtons, follow);
  const right = el("div", { class: "bar hands", role: "toolbar", "aria-label": "Tools" }, ...toolButtons,
    iconButton("snapshot", "Save a picture (p)", () => snapshot(stage)), iconButton("share", "Copy the address of this view (l)", share));
  host.append(left, right);
  const draw = () => {
    for (const button of viewButtons) button.setAttribute("aria-pressed", String(view.name === button.dataset.view));
    follow.setAttribute("aria-pressed", String(view.follow));
  };
  view.addEventListener("changed", draw);
  draw();
  hand.addEventListener("changed", () => {
    for (const button of toolButtons) button.setAttribute("aria-pressed", String(hand.name === button.dataset.tool));
  });
  const offer = (item) => {
    const can = item?.header.can ?? [];
    tools.forEach(({ can: needs }, i) => (toolButtons[i].hidden = Boolean(needs) && !can.includes(needs)));
    const live = item?.header.source !== "file";
    follow.hidden = viewButtons.find(({ dataset }) => dataset.view === "robot").hidden = !live;
  };
  board.on("about", offer);
  offer(null);
}
