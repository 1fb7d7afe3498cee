// One tooltip for the page: beside the pointer's or the keyboard's node, always up to date.

import { html, say } from "./dom.js";

const GAP = 10;

export class Tooltip {
  #box;
  #node = null;
  #lines = null;

  constructor(box) {
    this.#box = box;
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.#hide();
    });
    document.addEventListener("scroll", () => this.#hide(), { capture: true, passive: true });
  }

  /** Gives a node a tooltip: `lines()` says what it reads now, the first line is its title. */
  explain(node, lines) {
    const show = () => {
      this.#node = node;
      this.#lines = lines;
      this.refresh();
    };
    const hide = () => {
      if (this.#node === node) this.#hide();
    };
    node.addEventListener("pointerenter", show);
    node.addEventListener("focus", show);
    node.addEventListener("pointerleave", hide);
    node.addEventListener("blur", hide);
  }

  /** Says again what the shown tooltip's node has to say. */
  refresh() {
    const lines = this.#node?.isConnected ? this.#lines() : [];
    if (lines.length === 0) {
      this.#hide();
      return;
    }
    while (this.#box.children.length > lines.length) this.#box.lastChild.remove();
    while (this.#box.children.length < lines.length) this.#box.append(html("p"));
    lines.forEach((line, index) => say(this.#box.children[index], line));
    this.#box.hidden = false;
    this.#place();
  }

  #place() {
    const node = this.#node.getBoundingClientRect();
    const { offsetWidth: width, offsetHeight: height } = this.#box;
    const above = node.top - GAP - height;
    const left = node.left + node.width / 2 - width / 2;
    const top = above > 0 ? above : node.bottom + GAP;
    this.#box.style.left = `${Math.max(4, Math.min(left, innerWidth - width - 4))}px`;
    this.#box.style.top = `${top}px`;
  }

  #hide() {
    this.#node = null;
    this.#box.hidden = true;
  }
}
