// The legend, drawn with the map's own symbols so that the two can't drift apart.

import { html, svg } from "./dom.js";
import * as symbols from "./symbols.js";

const PILES = ["free", "reserved", "charging", "done", "fault", "unknown"];

const entry = (symbol, text) =>
  html(
    "span",
    { class: "entry" },
    svg("svg", { viewBox: "-18 -16 36 32", "aria-hidden": "true" }, symbol),
    text,
  );

function pile(availability) {
  const symbol = symbols.pileSymbol();
  symbols.drawPile(symbol, { id: "", availability, remaining: 0.6 });
  return entry(symbol, availability);
}

function door(open) {
  const symbol = symbols.doorSymbol();
  symbols.drawDoor(symbol, { open, congestion: open ? 0.4 : 0.8 });
  return entry(symbol, open ? "door" : "closed door");
}

function robot() {
  const symbol = symbols.robotSymbol();
  symbols.drawRobot(symbol, { id: "", at: [0, 0], activity: "working", battery: 0.6 });
  return entry(symbol, "robot");
}

export function legend() {
  const lease = svg("path", { class: "lease-line", d: "M-16 0H16" });
  return [...PILES.map(pile), robot(), entry(lease, "lease"), door(true), door(false)];
}
