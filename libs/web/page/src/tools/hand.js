// Which tool is in the hand. Without one a click inspects.

export class Hand extends EventTarget {
  /** @param {{inspect, measure, goto, drive}} tools */
  constructor(tools) {
    super();
    this.tools = tools;
    this.name = null;
    for (const tool of Object.values(tools)) tool.done = () => this.take(null);
  }

  /** Takes a tool, or lays it down when it is in the hand already. */
  take(name) {
    const next = name === this.name ? null : name;
    this.tools.inspect.leave();
    if (this.name) this.tools[this.name].leave();
    this.name = next;
    if (next) this.tools[next].enter();
    this.dispatchEvent(new Event("changed"));
  }

  get #tool() {
    return this.tools[this.name];
  }

  press(event) {
    return this.#tool?.press?.(event) ?? false;
  }

  /** The tool that was pressed may have been laid down meanwhile, or another one be in the hand. */
  drag(event) {
    this.#tool?.drag?.(event);
  }

  release(event, cancelled) {
    this.#tool?.release?.(event, cancelled);
  }

  click(event) {
    if (this.name === "drive") return;
    (this.#tool?.click ? this.#tool : this.tools.inspect).click(event);
  }
}
