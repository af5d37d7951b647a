// The newest item of each channel and key, as the server's board has it, and who shows it.

const bulk = ["points", "mesh", "landmarks", "path"];
const quiet = 3; // s without bulk, or after all of it has come, after which what was not sent again is taken for gone

export class Board {
  #channels = new Map();
  #listeners = new Map();
  #stale = new Set();
  #sweep = 0;
  #isWhole = false; // the server has sent all that it has

  /** @param {(item: object|null, key: string) => void} listener told of each change; null: the item is gone */
  on(channel, listener) {
    const list = this.#listeners.get(channel) ?? [];
    list.push(listener);
    this.#listeners.set(channel, list);
  }

  get(channel, key = "") {
    return this.#channels.get(channel)?.get(key);
  }

  put(item) {
    const { channel, key } = item;
    if (item.header.gone) {
      if (key === "") for (const each of [...(this.#channels.get(channel)?.keys() ?? [])]) this.#remove(channel, each);
      else this.#remove(channel, key);
      return;
    }
    if (!this.#channels.has(channel)) this.#channels.set(channel, new Map());
    this.#channels.get(channel).set(key, item);
    this.#stale.delete(`${channel} ${key}`);
    if (this.#stale.size > 0 && !this.#isWhole && bulk.includes(channel)) this.#sweepLater();
    for (const listener of this.#listeners.get(channel) ?? []) listener(item, key);
  }

  /** Everything goes: another map is shown from now on. */
  clear() {
    for (const [channel, items] of this.#channels) for (const key of [...items.keys()]) this.#remove(channel, key);
    this.#stale.clear();
  }

  /** The server sends its board anew: what it does not name again goes once its bulk has come. */
  expectAnew() {
    for (const [channel, items] of this.#channels)
      for (const key of items.keys()) if (channel !== "about") this.#stale.add(`${channel} ${key}`);
    this.#isWhole = false;
    this.#sweepLater();
  }

  /** All of the server's board has come. What changes from here on, as a map does each second, keeps nothing that is old. */
  expectNoMore() {
    if (this.#stale.size === 0 || this.#isWhole) return;
    this.#isWhole = true;
    this.#sweepLater();
  }

  #remove(channel, key) {
    const items = this.#channels.get(channel);
    if (!items?.delete(key)) return;
    for (const listener of this.#listeners.get(channel) ?? []) listener(null, key);
  }

  #sweepLater() {
    clearTimeout(this.#sweep);
    this.#sweep = setTimeout(() => {
      for (const name of this.#stale) {
        const space = name.indexOf(" ");
        this.#remove(name.slice(0, space), name.slice(space + 1));
      }
      this.#stale.clear();
    }, quiet * 1000);
  }

  /** The connection went: nothing may be taken for gone now. */
  hold() {
    clearTimeout(this.#sweep);
  }
}
