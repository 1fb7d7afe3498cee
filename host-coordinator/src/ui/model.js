// What the coordinator last said, and what follows from it. No node of the page is touched here.

const DECISIONS_KEPT = 50;

const byId = (rows) => new Map((rows ?? []).map((row) => [row.id, row]));

export class Model {
  site = null;
  now = null;
  epoch = null;
  insecure = false;
  degraded = null;
  warnings = [];
  totals = {};
  helps = [];
  piles = new Map();
  robots = new Map();
  doors = new Map();
  decisions = [];

  /** Takes one message of /api/v1/changes; says whether the site itself may have changed. */
  take(message) {
    this.now = message.now_ms;
    this.epoch = message.epoch;
    this.degraded = message.degraded;
    this.warnings = message.warnings ?? [];
    this.totals = message.totals ?? this.totals;
    this.helps = message.helps ?? [];
    if (message.type === "state") {
      this.site = message.site;
      this.insecure = message.insecure;
      this.doors = byId(message.site.doors);
      this.piles = byId(message.piles);
      this.robots = byId(message.robots);
      this.decisions = message.decisions ?? [];
      return true;
    }
    for (const table of ["piles", "robots", "doors"]) {
      for (const row of message[table] ?? []) this[table].set(row.id, row);
    }
    if (message.decisions?.length) {
      const all = byId([...this.decisions, ...message.decisions]);
      this.decisions = [...all.values()].sort((a, b) => b.id - a.id).slice(0, DECISIONS_KEPT);
    }
    return false;
  }

  /** Which piles and robots a selection is about; null if nothing is selected. */
  involved(selection) {
    if (!selection) return null;
    const piles = new Set();
    const robots = new Set();
    const { kind, id } = selection;
    if (kind === "pile") {
      const pile = this.piles.get(id);
      piles.add(id);
      for (const robot of [pile?.holder, pile?.next]) if (robot != null) robots.add(robot);
    } else if (kind === "robot") {
      robots.add(id);
      const pile = this.robots.get(id)?.pile;
      if (pile != null) piles.add(pile);
    } else {
      const decision = this.decisions.find((row) => row.id === id);
      if (!decision) return null;
      robots.add(decision.robot);
      if (decision.chosen != null) piles.add(decision.chosen);
    }
    return { piles, robots };
  }
}
