// The symbols of the map, in CSS pixels around their own origin. Each state has a shape or a word
// of its own, so that nothing is told by colour alone.

import { say, set, svg } from "./dom.js";
import { battery, number, percent, pileState, robotState } from "./words.js";

export const PILE_RADIUS = 14;
const CORE_RADIUS = 9.5;
const BODY = { width: 28, height: 16 };
const BATTERY_LOW = 0.2;

/** A pile: a core (hollow while its place is empty), a ring that empties, its id, a word below. */
export function pileSymbol() {
  const ring = { r: PILE_RADIUS - 2, pathLength: 100, transform: "rotate(-90)" };
  return svg(
    "g",
    { class: "pile symbol" },
    svg("circle", { class: "halo", r: PILE_RADIUS + 4 }),
    svg("circle", { class: "plate", r: PILE_RADIUS }),
    svg("circle", { class: "track", ...ring }),
    svg("circle", { class: "remaining", ...ring }),
    svg("circle", { class: "core", r: CORE_RADIUS }),
    svg("text", { class: "id" }),
    svg("text", { class: "word", y: PILE_RADIUS + 10 }),
  );
}

export function drawPile(symbol, pile) {
  const state = pileState(pile);
  set(symbol, { "data-state": state });
  const [, , , remaining, , id, word] = symbol.children;
  const share = state === "charging" ? Math.min(1, Math.max(0, pile.remaining || 0)) : 0;
  set(remaining, { "stroke-dasharray": `${share * 100} 100` });
  say(id, String(pile.id));
  say(word, state === "charging" ? `${percent(pile.remaining)} to go` : state);
}

/** A robot: a battery with its id on it and a badge when it needs a look. */
export function robotSymbol() {
  const { width, height } = BODY;
  const box = { x: -width / 2, y: -height / 2, height, rx: 4.5 };
  return svg(
    "g",
    { class: "robot symbol" },
    svg("rect", { class: "halo", x: -width / 2 - 4, y: -height / 2 - 4, width: width + 8, height: height + 8, rx: 8 }),
    svg("rect", { class: "body", ...box, width }),
    svg("rect", { class: "battery", ...box, width: 0 }),
    svg("rect", { class: "outline", ...box, width }),
    svg("text", { class: "id" }),
    svg(
      "g",
      { class: "badge", transform: `translate(${width / 2} ${-height / 2})` },
      svg("circle", { r: 6.5 }),
      svg("text", {}),
    ),
  );
}

export function batteryLow(robot) {
  const share = battery(robot);
  return share !== null && share < BATTERY_LOW;
}

export function drawRobot(symbol, robot) {
  const state = robotState(robot);
  set(symbol, { "data-state": state, "data-low": batteryLow(robot) ? "" : null });
  const [, , level, , id, badge] = symbol.children;
  const share = Math.min(1, Math.max(0, battery(robot) || 0));
  set(level, { width: (BODY.width * share).toFixed(1) });
  say(id, `R${robot.id}`);
  say(badge.lastChild, { stranded: "!", waiting: "···", unknown: "?" }[state] ?? "");
}

/** A door: a diamond that fills with congestion, a no-entry sign when closed. */
export function doorSymbol() {
  return svg(
    "g",
    { class: "door symbol" },
    svg("path", { class: "diamond", d: "M0-7.5 7.5 0 0 7.5-7.5 0z" }),
    svg("path", { class: "no-entry", d: "M-7.5 0a7.5 7.5 0 1 0 15 0a7.5 7.5 0 1 0-15 0z" }),
    svg("path", { class: "bar", d: "M-4 0H4" }),
  );
}

/** What is written beside a door; where there is little room, without its congestion. */
export function doorLabel({ id, congestion, open }, roomy) {
  return `D${id}${roomy ? ` ${number(congestion, 2)}` : ""}${open ? "" : " closed"}`;
}

export function drawDoor(symbol, door) {
  set(symbol, { "data-open": door.open ? "" : null });
  const share = Math.min(1, Math.max(0, door.congestion || 0));
  symbol.style.setProperty("--congestion", `${Math.round(share * 100)}%`);
}
