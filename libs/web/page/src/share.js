// The address holds the view: #at=x,y,z&turn=yaw,pitch&far=m&view=robot&follow=1&on=grid&off=points

/** @returns what the address asks for; nothing that cannot be read is taken */
export function readAddress(hash = location.hash) {
  const members = new URLSearchParams(hash.replace(/^#/, ""));
  const numbers = (name, n) => {
    const words = (members.get(name) ?? "").split(",");
    const values = words.map(Number);
    return values.length === n && values.every((value, i) => words[i] !== "" && Number.isFinite(value)) ? values : null;
  };
  const names = (name) => (members.get(name) ?? "").split(",").filter((word) => word !== "");
  return {
    at: numbers("at", 3),
    turn: numbers("turn", 2),
    far: numbers("far", 1)?.[0] ?? null,
    view: members.get("view"),
    follow: members.has("follow") ? members.get("follow") === "1" : null,
    on: names("on"),
    off: names("off"),
  };
}

/** The view and the switches as a hash. */
export function writeAddress(view, switches) {
  const short = (values) => values.map((value) => Number(value.toFixed(2))).join(",");
  const members = view.untouched ? [] : [`at=${short(view.target.toArray())}`, `turn=${short([view.yaw, view.pitch])}`, `far=${short([view.distance])}`];
  if (view.name !== "free") members.push(`view=${view.name}`);
  if (view.follow) members.push("follow=1");
  const { on, off } = switches.differences();
  if (on.length) members.push(`on=${on}`);
  if (off.length) members.push(`off=${off}`);
  return members.length > 0 ? `#${members.join("&")}` : "";
}

/** Keeps the address up to date, without a new entry in the history. */
export class AddressKeeper {
  #timer = 0;

  constructor(view, switches) {
    this.write = () => history.replaceState(null, "", location.pathname + writeAddress(view, switches));
  }

  later() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(this.write, 400);
  }
}
