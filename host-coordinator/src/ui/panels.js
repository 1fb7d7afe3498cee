// The lists beside the map: totals, piles, robots, decisions.

import { html, reconcile, say, set, svg } from "./dom.js";
import * as symbols from "./symbols.js";
import {
  battery,
  clock,
  duration,
  helpLine,
  number,
  percent,
  pileLine,
  pileState,
  plain,
  robotLine,
  robotState,
  stage,
} from "./words.js";

const TOTALS = [
  { id: "charges_completed", name: "charges", say: String },
  { id: "mean_wait_s", name: "mean wait", say: duration },
  { id: "worst_wait_s", name: "worst wait", say: duration },
  { id: "waiting", name: "waiting", say: String, alert: "caution" },
  { id: "stranded", name: "stranded", say: String, alert: "danger" },
];

export function updateTotals(list, totals) {
  const create = ({ name }) => html("div", {}, html("dt", {}, name), html("dd"));
  reconcile(list, TOTALS, create, (node, row) => {
    const value = totals[row.id];
    say(node.lastChild, value === undefined || value === null ? "–" : row.say(value));
    set(node, { "data-alert": row.alert && value > 0 ? row.alert : null });
  });
}

/** A row that is a button; `select` is called with its kind and id. */
function rowButton(kind, id, select, ...cells) {
  const button = html("button", { type: "button" }, ...cells);
  button.addEventListener("click", () => select(kind, id));
  return html("li", {}, button);
}

const meter = () => html("span", { class: "meter" }, html("span"));
const fill = (node, share) =>
  node.firstChild.style.setProperty("width", `${Math.min(1, Math.max(0, share || 0)) * 100}%`);

export function updatePiles(list, model, involved, select) {
  const create = ({ id }) =>
    rowButton(
      "pile",
      id,
      select,
      svg("svg", { viewBox: "-15 -15 30 30", class: "key", "aria-hidden": "true" }, symbols.pileSymbol()),
      html("span", { class: "what" }),
      meter(),
      html("span", { class: "who" }),
    );
  reconcile(list, model.piles.values(), create, (node, pile) => {
    const [key, what, remaining, who] = node.firstChild.children;
    const state = pileState(pile);
    set(node, { "data-state": state, "data-involved": involved?.piles.has(pile.id) ? "" : null });
    set(node.firstChild, { "aria-label": `Pile ${pile.id}: ${pileLine(pile)}` });
    symbols.drawPile(key.firstChild, pile);
    const charging = state === "charging";
    const left = pile.planned_s - pile.elapsed_s;
    const short = charging && left > 0 ? duration(left) : state;
    say(what, state === "fault" ? pileLine(pile) : short);
    set(remaining, { "data-empty": charging ? null : "" });
    fill(remaining, pile.remaining);
    const next = pile.next == null ? "" : ` ‹ R${pile.next}`;
    say(who, `${pile.holder == null ? "" : `R${pile.holder}`}${next}`);
  });
}

export function updateRobots(list, model, involved, select) {
  const create = ({ id }) =>
    rowButton(
      "robot",
      id,
      select,
      html("span", { class: "name" }, `R${id}`),
      html("span", { class: "what" }),
      meter(),
      html("span", { class: "who" }),
    );
  reconcile(list, model.robots.values(), create, (node, robot) => {
    const [, what, bar, level] = node.firstChild.children;
    set(node, {
      "data-state": robotState(robot),
      "data-low": symbols.batteryLow(robot) ? "" : null,
      "data-involved": involved?.robots.has(robot.id) ? "" : null,
    });
    const line = robotLine(robot);
    const lost = robot.at || line === "unknown" ? "" : ", place unknown";
    set(node.firstChild, { "aria-label": `Robot ${robot.id}: ${line}${lost}, battery ${percent(battery(robot))}` });
    say(what, `${line}${lost}`);
    fill(bar, battery(robot));
    say(level, percent(battery(robot)));
  });
}

/** The robots that need help; `moved` is called with one that a person has moved. */
export function updateHelps(list, helps, moved) {
  const create = ({ robot }) => {
    const button = html("button", { type: "button" }, "It was moved");
    button.addEventListener("click", () => moved(robot));
    return html("li", {}, html("span"), button);
  };
  const rows = helps.map((help) => ({ id: help.robot, ...help }));
  reconcile(list, rows, create, (node, help) => {
    const [line, button] = node.children;
    say(line, helpLine(help));
    set(node, { "data-stage": help.stage });
    button.hidden = help.stage !== "tow";
  });
}

export function updateDecisions(list, model, selection, select) {
  const create = (decision) =>
    rowButton(
      "decision",
      decision.id,
      select,
      html("time", {}, clock(decision.at_ms)),
      html("span", { class: "what" }, headline(decision)),
      html("span", { class: "why" }, stage(decision.stage)),
    );
  reconcile(list, model.decisions, create, (item, decision) => {
    const open = selection?.kind === "decision" && selection.id === decision.id;
    set(item, { "data-involved": open ? "" : null, "data-none": decision.chosen == null ? "" : null });
    set(item.firstChild, { "aria-expanded": open });
    const shown = item.children.length > 1;
    if (open && !shown) item.append(explanation(decision));
    else if (!open && shown) item.lastChild.remove();
  });
}

const headline = ({ robot, chosen }) =>
  chosen == null ? `R${robot} has to wait` : `R${robot} → pile ${chosen}`;

/** From the decision until the robot works again: way, wait, charge, way back; null where nobody asked. */
function away({ times }) {
  if (!times) return null;
  const way = times.drive_s + times.doors_s;
  return Math.max(way, times.free_in_s) + times.charge_s + times.back_s;
}

// The chosen pile first, then by what the policy ranks by, then by distance; unknown last.
const rank = (row, decision) => [
  row.pile === decision.chosen ? 0 : 1,
  -(row.score ?? -Infinity),
  away(row) ?? Infinity,
  row.distance ?? Infinity,
];

function explanation(decision) {
  const rows = [...(decision.explanations ?? [])].sort((a, b) => {
    const [left, right] = [rank(a, decision), rank(b, decision)];
    const index = left.findIndex((value, at) => value !== right[at]);
    return index < 0 ? a.pile - b.pile : left[index] - right[index];
  });
  const timed = rows.some((row) => row.times);
  const head = ["Pile", "Stage", "Distance", "p", timed ? "Away" : "Score", "Verdict"];
  const cells = (row) => [
    html("th", { scope: "row" }, String(row.pile)),
    html("td", {}, row.stage == null ? "–" : plain(row.stage)),
    html("td", { class: "number" }, row.distance == null ? "no path" : number(row.distance)),
    html("td", { class: "number" }, number(row.probability, 2)),
    html("td", { class: "number" }, timed ? duration(away(row)) : number(row.score, 3)),
    html("td", { class: "reason", title: row.unless ? `Could be chosen ${row.unless}` : null }, row.reason ?? plain(row.verdict)),
  ];
  return html(
    "div",
    { class: "explanation" },
    html(
      "p",
      {},
      `Robot ${decision.robot} can still drive ${number(decision.reach)} cells: ${stage(decision.stage)}. ` +
        "p is how likely it is to work near the pile after the charge." +
        (timed ? " Away: way, wait, charge and way back to work." : ""),
    ),
    html(
      "table",
      {},
      html("thead", {}, html("tr", {}, ...head.map((name) => html("th", { scope: "col" }, name)))),
      html(
        "tbody",
        {},
        ...rows.map((row) => html("tr", { "data-chosen": row.pile === decision.chosen ? "" : null }, ...cells(row))),
      ),
    ),
  );
}
