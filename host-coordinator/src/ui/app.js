// The page: the link feeds the model, the model is drawn, clicks select.

import { html, reconcile, say, set } from "./dom.js";
import { legend } from "./legend.js";
import { connect } from "./link.js";
import { SiteMap } from "./map.js";
import { Model } from "./model.js";
import { updateDecisions, updateHelps, updatePiles, updateRobots, updateTotals } from "./panels.js";
import { Tooltip } from "./tooltip.js";
import { clock } from "./words.js";

const $ = (selector) => document.querySelector(selector);

const model = new Model();
const tooltip = new Tooltip($("#tooltip"));
let selection = null;
let link = { state: "connecting" };
let scheduled = false;
let rebuilt = false;
let failure = null;

/** Selects a pile, robot or decision; the same once more, or null, selects nothing. */
function select(kind, id) {
  const again = selection?.kind === kind && selection.id === id;
  selection = kind === null || again ? null : { kind, id };
  schedule();
}

const map = new SiteMap($("#canvas"), model, {
  select,
  explain: (node, lines) => tooltip.explain(node, lines),
});

// Messages may come faster than frames: each frame draws the newest.
function schedule() {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(() => {
    scheduled = false;
    draw();
  });
}

function draw() {
  drawAlarm();
  if (!model.site) return;
  if (rebuilt) {
    map.rebuild();
    rebuilt = false;
    document.title = `${model.site.name} · Chargehand`;
    say($("#site-name"), model.site.name);
  }
  const involved = model.involved(selection);
  if (!involved) selection = null;
  map.update(involved);
  updateTotals($("#totals"), model.totals);
  updatePiles($("#piles ul"), model, involved, select);
  updateRobots($("#robots ul"), model, involved, select);
  updateDecisions($("#decisions ol"), model, selection, select);
  $("#decisions .empty").hidden = model.decisions.length > 0;
  say($("#clock"), `${clock(model.now)} · epoch ${model.epoch}`);
  drawLost();
  drawWarnings();
  $("#helps").hidden = model.helps.length === 0;
  updateHelps($("#helps ul"), model.helps, moved);
  tooltip.refresh();
}

function drawAlarm() {
  const { state, retryAt } = link;
  const seconds = Math.ceil((retryAt - Date.now()) / 1000);
  const retry = seconds > 0 ? `trying again in ${seconds} s` : "trying again";
  set($("#link"), { "data-link": state });
  say($("#link"), state === "lost" ? `disconnected, ${retry}` : state);
  set(document.body, { "data-stale": state === "lost" ? "" : null });
  // An alarm is read out whenever its text changes, so that the countdown stands elsewhere.
  const alarms = [];
  if (state === "lost") {
    const age = model.now === null ? "" : ` What you see is from ${clock(model.now)}.`;
    alarms.push(`No connection to the coordinator.${age}`);
  }
  if (failure) alarms.push(`This page failed and may show old data. Reload it. (${failure})`);
  if (model.insecure) {
    alarms.push("Insecure: without keys, whoever can reach the site's network can command it.");
  }
  if (model.degraded) alarms.push(`Degraded: ${model.degraded}`);
  $("#alarm").hidden = alarms.length === 0;
  say($("#alarm"), alarms.join("\n"));
}

function drawLost() {
  const lost = [...model.robots.values()].filter((robot) => !robot.at).map((robot) => `R${robot.id}`);
  $("#lost").hidden = lost.length === 0;
  say($("#lost"), `Not on the map, place unknown: ${lost.join(", ")}`);
}

function drawWarnings() {
  const rows = model.warnings.map((text, id) => ({ id, text }));
  $("#warnings").hidden = rows.length === 0;
  say($("#warnings summary"), rows.length === 1 ? "1 warning" : `${rows.length} warnings`);
  reconcile($("#warnings ul"), rows, () => html("li"), (node, row) => say(node, row.text));
}

/** A person has moved a robot that was to be towed. */
async function moved(robot) {
  const headers = { "content-type": "application/json" };
  try {
    const answer = await fetch(`/api/v1/tows/${robot}`, { method: "POST", headers, body: "{}" });
    if (!answer.ok) window.alert((await answer.json()).message);
  } catch {
    window.alert("The coordinator cannot be reached: nothing was recorded. Try again.");
  }
}

document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") select(null);
});
// A page that has stopped drawing must not look alive.
window.addEventListener("error", ({ message }) => {
  failure = message;
  drawAlarm();
});
// The countdown to the next attempt.
setInterval(() => {
  if (link.state === "lost") schedule();
}, 500);

$("#legend").append(...legend());
connect(
  "/api/v1/changes",
  (message) => {
    if (model.take(message)) rebuilt = true;
    schedule();
  },
  (now) => {
    link = now;
    schedule();
  },
);
