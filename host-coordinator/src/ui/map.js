// The picture of the site: walls, subareas and doors below, then routes, piles and robots.

import { html, reconcile, say, set, svg } from "./dom.js";
import { legOf, placeLabel, wallPath } from "./geometry.js";
import { Glide } from "./motion.js";
import * as symbols from "./symbols.js";
import { battery, number, percent, pileLine, place, plain, robotLine, robotState } from "./words.js";

const MARGIN = 32;
// Symbols keep their size in pixels, but shrink where a cell has fewer than this.
const FULL_SIZE_CELL = 5;
const SMALLEST_SYMBOL = 0.8;
// A subarea's name of more letters is written smaller.
const SHORT_NAME = 3;
const LABEL = { height: 15, letter: 6.3, padding: 8 };
// A docked robot is drawn beside its pile, towards the middle of the map.
const BESIDE_PILE = symbols.PILE_RADIUS + 18;

export class SiteMap {
  #canvas;
  #page;
  #model;
  #glide = new Glide((id, at) => this.#move(id, at));
  #legs = new Map();
  #scale = 1;
  #symbolSize = 1;
  #layers = null;
  #involved = null;

  /** `page` offers `select(kind, id)` and `explain(node, lines)`, which gives a node a tooltip. */
  constructor(canvas, model, page) {
    this.#canvas = canvas;
    this.#model = model;
    this.#page = page;
    new ResizeObserver(() => this.#layOut()).observe(canvas);
  }

  /** Draws a new site from the ground up. */
  rebuild() {
    const { site } = this.#model;
    this.#legs.clear();
    const layer = (name) => svg("g", { class: name });
    const layers = {
      ground: layer("ground"),
      subareas: layer("subareas"),
      routes: layer("routes"),
      doors: layer("doors"),
      labels: layer("labels"),
      piles: layer("piles"),
      robots: layer("robots"),
    };
    layers.ground.append(
      svg("rect", { class: "floor", width: site.width, height: site.height }),
      svg("path", { class: "wall", d: wallPath(site.walls) }),
      svg("rect", { class: "edge", width: site.width, height: site.height }),
    );
    const drawing = svg("svg", { role: "group", "aria-label": `Map of ${site.name}` });
    drawing.append(...Object.values(layers));
    const readout = html("p", { id: "readout", "aria-hidden": "true" });
    drawing.addEventListener("pointermove", (event) => say(readout, this.#cellUnder(event)));
    drawing.addEventListener("pointerleave", () => say(readout, ""));
    drawing.addEventListener("click", (event) => {
      if (!event.target.closest(".symbol")) this.#page.select(null);
    });
    this.#layers = layers;
    this.#canvas.replaceChildren(drawing, readout);
    this.#canvas.style.setProperty("--aspect", site.width / site.height);
    this.#layOut();
  }

  /** Draws what has changed in the model, with the selection's piles and robots in front. */
  update(involved) {
    if (!this.#layers) return;
    this.#involved = involved;
    const { piles, robots, doors } = this.#model;
    const layers = this.#layers;
    set(this.#canvas.firstChild, { class: involved ? "focused" : null });
    reconcile(layers.doors, doors.values(), (row) => this.#makeDoor(row), (node, row) => {
      symbols.drawDoor(node, row);
      set(node, { "aria-label": this.#doorLines(row).join(", ") });
    });
    reconcile(layers.piles, piles.values(), (row) => this.#make("pile", row), (node, row) => {
      symbols.drawPile(node, row);
      this.#mark(node, "pile", row, involved?.piles);
    });
    const placed = [...robots.values()].filter((robot) => robot.at);
    reconcile(layers.robots, placed, (row) => this.#make("robot", row), (node, row) => {
      symbols.drawRobot(node, row);
      this.#mark(node, "robot", row, involved?.robots);
    });
    this.#updateRoutes(placed);
    this.#glide.follow(placed.map((robot) => ({ id: robot.id, at: robot.at })));
    for (const robot of placed) this.#move(robot.id, this.#glide.place(robot.id));
    this.#placeLabels();
  }

  #make(kind, { id }) {
    const node = kind === "pile" ? symbols.pileSymbol() : symbols.robotSymbol();
    set(node, { tabindex: 0, role: "button" });
    const choose = () => this.#page.select(kind, id);
    node.addEventListener("click", choose);
    node.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      choose();
    });
    this.#page.explain(node, () => this.#lines(kind, id));
    if (kind === "pile") this.#put(node, this.#model.piles.get(id).at);
    return node;
  }

  #makeDoor({ id, at }) {
    const node = symbols.doorSymbol();
    set(node, { tabindex: 0, role: "img" });
    this.#page.explain(node, () => this.#doorLines(this.#model.doors.get(id)));
    this.#put(node, at);
    return node;
  }

  #mark(node, kind, { id }, involved) {
    set(node, {
      "data-involved": involved?.has(id) ? "" : null,
      "aria-label": this.#lines(kind, id).join(", "),
    });
  }

  #lines(kind, id) {
    const { site } = this.#model;
    if (kind === "pile") {
      const pile = this.#model.piles.get(id);
      if (!pile) return [];
      return [
        `Pile ${id} at ${place(site, pile.at)}`,
        pileLine(pile),
        pile.holder == null ? "no robot holds it" : `held by robot ${pile.holder}`,
        pile.lease?.phase == null || pile.lease.phase === "held" ? null : `lease ${plain(pile.lease.phase)}`,
        pile.next == null ? null : `next: robot ${pile.next}`,
        pile.energised ? "contacts energised" : null,
      ].filter(Boolean);
    }
    const robot = this.#model.robots.get(id);
    if (!robot) return [];
    return [`Robot ${id} at ${place(site, robot.at)}`, robotLine(robot), `battery ${percent(battery(robot))}`];
  }

  #doorLines(door) {
    if (!door) return [];
    return [
      `Door ${door.id} at ${place(this.#model.site, door.at)}`,
      `joins ${door.joins.join(" and ")}`,
      `congestion ${number(door.congestion, 2)}`,
      door.open ? "open to routes" : "closed to routes: too congested",
    ];
  }

  // A route is drawn from where its robot is drawn to its end.
  #updateRoutes(robots) {
    const rows = robots.filter((robot) => robot.route?.length > 1 || linkOnly(robot));
    reconcile(
      this.#layers.routes,
      rows,
      () => svg("g", { class: "route" }, svg("path", {}), svg("circle", { r: 3.5 })),
      (node, robot) => {
        const state = robotState(robot);
        const leased = robot.pile != null && this.#model.piles.get(robot.pile)?.holder === robot.id;
        set(node, {
          "data-to": robot.pile == null ? "work" : leased ? "pile" : "next",
          "data-state": state,
          "data-involved": this.#involved?.robots.has(robot.id) ? "" : null,
        });
        this.#track(robot);
      },
    );
    for (const id of this.#legs.keys()) if (!this.#model.robots.has(id)) this.#legs.delete(id);
  }

  #track(robot) {
    const { id, route = [], at } = robot;
    const key = `${route.length} ${route[0]} ${route.at(-1)}`;
    const known = this.#legs.get(id);
    const from = known?.key === key ? known.leg : 0;
    this.#legs.set(id, { key, leg: legOf(route, at, from) });
  }

  #move(id, at) {
    const node = this.#layers.robots.rows?.get(id);
    const robot = this.#model.robots.get(id);
    if (!node || !robot || !at) return;
    const docked = ["docked", "charging"].includes(robotState(robot)) && this.#model.piles.has(robot.pile);
    const side = at[0] < this.#model.site.width / 2 ? 1 : -1;
    this.#put(node, at, docked ? side * BESIDE_PILE : 0);
    const route = this.#layers.routes.rows?.get(id);
    if (route) this.#drawRoute(route, robot, at);
  }

  #drawRoute(node, robot, at) {
    const [path, end] = node.children;
    const route = robot.route?.length > 1 ? robot.route : [at, this.#model.piles.get(robot.pile)?.at ?? at];
    const ahead = route.slice((this.#legs.get(robot.id)?.leg ?? 0) + 1).map((cell) => this.#pixels(cell));
    const points = [this.#pixels(at), ...ahead].map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`);
    set(path, { d: `M${points.join("L")}` });
    const [x, y] = ahead.at(-1) ?? this.#pixels(at);
    set(end, { cx: x, cy: y });
  }

  #pixels([x, y]) {
    return [MARGIN + (x + 0.5) * this.#scale, MARGIN + (y + 0.5) * this.#scale];
  }

  #put(node, at, aside = 0) {
    const [x, y] = this.#pixels(at);
    const shift = `translate(${(x + aside * this.#symbolSize).toFixed(2)} ${y.toFixed(2)})`;
    set(node, { transform: `${shift} scale(${this.#symbolSize})` });
  }

  #cellUnder(event) {
    const box = this.#canvas.firstChild.getBoundingClientRect();
    const { site } = this.#model;
    const x = Math.floor((event.clientX - box.left - MARGIN) / this.#scale);
    const y = Math.floor((event.clientY - box.top - MARGIN) / this.#scale);
    const inside = x >= 0 && y >= 0 && x < site.width && y < site.height;
    return inside ? place(site, [x, y]) : "";
  }

  #layOut() {
    if (!this.#layers) return;
    const { site, piles, doors } = this.#model;
    const { clientWidth: width, clientHeight: height } = this.#canvas;
    this.#scale = Math.min((width - 2 * MARGIN) / site.width, (height - 2 * MARGIN) / site.height);
    this.#symbolSize = Math.min(1, Math.max(SMALLEST_SYMBOL, this.#scale / FULL_SIZE_CELL));
    const size = { width: site.width * this.#scale + 2 * MARGIN, height: site.height * this.#scale + 2 * MARGIN };
    set(this.#canvas.firstChild, size);
    set(this.#layers.ground, { transform: `translate(${MARGIN} ${MARGIN}) scale(${this.#scale})` });
    this.#layers.subareas.replaceChildren(
      ...site.subareas.map(({ name, at }) => {
        const [x, y] = this.#pixels(at);
        return svg("text", { x, y, "data-long": name.length > SHORT_NAME ? "" : null }, name);
      }),
    );
    for (const [id, node] of this.#layers.piles.rows ?? []) this.#put(node, piles.get(id).at);
    for (const [id, node] of this.#layers.doors.rows ?? []) this.#put(node, doors.get(id).at);
    for (const id of this.#layers.robots.rows?.keys() ?? []) this.#move(id, this.#glide.place(id));
    this.#placeLabels();
  }

  // Doors may stand two cells apart: each label goes where it covers least.
  #placeLabels() {
    const { piles, doors, site } = this.#model;
    const texts = [...doors.values()].map((door) => symbols.doorLabel(door, this.#symbolSize === 1));
    const key = `${this.#scale} ${texts} ${[...piles.keys()]}`;
    if (this.#layers.labels.key === key) return;
    this.#layers.labels.key = key;
    const around = (at, size, below = 0) => {
      const half = size * this.#symbolSize;
      const [x, y] = this.#pixels(at);
      return { x: x - half, y: y - half, width: 2 * half, height: 2 * half + below };
    };
    const taken = [
      ...[...piles.values()].map((pile) => around(pile.at, symbols.PILE_RADIUS + 4, 10)),
      ...[...doors.values()].map((door) => around(door.at, 8)),
      ...site.subareas.map((subarea) => around(subarea.at, 12)),
    ];
    const bounds = { x: 0, y: 0, width: site.width * this.#scale + 2 * MARGIN, height: site.height * this.#scale + 2 * MARGIN };
    const labels = [...doors.values()].map((door, index) => {
      const width = texts[index].length * LABEL.letter + LABEL.padding;
      const box = placeLabel(this.#pixels(door.at), width, LABEL.height, 10, taken, bounds);
      taken.push(box);
      const middle = { x: box.x + width / 2, y: box.y + LABEL.height / 2 };
      return svg(
        "g",
        { class: "label", "data-open": door.open ? "" : null },
        svg("rect", { ...box, rx: 4 }),
        svg("text", middle, texts[index]),
      );
    });
    this.#layers.labels.replaceChildren(...labels);
  }
}

// A robot on its way to a pile of which no route is known: a straight line says where to.
const linkOnly = (robot) => robot.pile != null && robotState(robot) === "approaching";
