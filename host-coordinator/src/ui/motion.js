// Robots are told of ten times a second at most; between two tellings they glide.

const STILL = window.matchMedia("(prefers-reduced-motion: reduce)");
const LONGEST_GLIDE_MS = 1_000;
// Further than this in one telling is no drive: a restart, or a link that was lost.
const JUMP_CELLS = 12;

export class Glide {
  #moving = new Map();
  #places = new Map();
  #told = 0;
  #interval = 200;
  #frame = null;
  #onMove;

  /** Calls `onMove(id, [x, y])` whenever a robot's drawn place changes. */
  constructor(onMove) {
    this.#onMove = onMove;
  }

  /** Takes every robot's place, `{id, at}`; the drawn places follow. */
  follow(robots) {
    const now = performance.now();
    // The usual time between tellings, smoothed: a glide shorter than it would stutter.
    if (this.#told) {
      const passed = Math.min(now - this.#told, LONGEST_GLIDE_MS);
      this.#interval += (passed - this.#interval) / 8;
    }
    this.#told = now;
    const seen = new Set();
    for (const { id, at } of robots) {
      seen.add(id);
      const from = this.#places.get(id);
      if (from?.[0] === at[0] && from?.[1] === at[1]) continue;
      const near = from && Math.hypot(at[0] - from[0], at[1] - from[1]) < JUMP_CELLS;
      if (near && !STILL.matches) {
        const going = this.#moving.get(id);
        if (going?.to[0] === at[0] && going.to[1] === at[1]) continue;
        this.#moving.set(id, { from, to: at, start: now, length: this.#interval * 1.2 });
      } else {
        this.#put(id, at);
      }
    }
    for (const id of this.#places.keys()) if (!seen.has(id)) this.#forget(id);
    this.#frame ??= requestAnimationFrame((time) => this.#advance(time));
  }

  /** Where a robot is drawn now. */
  place(id) {
    return this.#places.get(id);
  }

  #put(id, at) {
    this.#moving.delete(id);
    this.#places.set(id, at);
    this.#onMove(id, at);
  }

  #forget(id) {
    this.#moving.delete(id);
    this.#places.delete(id);
  }

  #advance(time) {
    this.#frame = null;
    for (const [id, { from, to, start, length }] of this.#moving) {
      const share = Math.min(1, Math.max(0, (time - start) / length));
      const at = [from[0] + (to[0] - from[0]) * share, from[1] + (to[1] - from[1]) * share];
      if (share === 1) {
        this.#put(id, to);
      } else {
        this.#places.set(id, at);
        this.#onMove(id, at);
      }
    }
    if (this.#moving.size) this.#frame = requestAnimationFrame((next) => this.#advance(next));
  }
}
