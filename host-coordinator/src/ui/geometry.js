// Plain geometry for the map: walls, routes, labels. Units are cells or CSS pixels as named.

/**
 * The walls as one path in cells. Runs that lie under each other with the same ends become one
 * rectangle, so that no seams show between rows.
 */
export function wallPath(runs) {
  const done = [];
  const open = new Map();
  for (const [x, y, length] of [...runs].sort((a, b) => a[1] - b[1])) {
    const key = `${x} ${length}`;
    const above = open.get(key);
    if (above && above.y + above.rows === y) {
      above.rows += 1;
    } else {
      const box = { x, y, length, rows: 1 };
      open.set(key, box);
      done.push(box);
    }
  }
  return done.map(({ x, y, length, rows }) => `M${x} ${y}h${length}v${rows}h${-length}z`).join("");
}

/**
 * Which leg of a route a robot is on: the one nearest to it, looked for from leg `from` on,
 * because a route may come close to itself.
 */
export function legOf(route, at, from) {
  let best = { leg: from, distance: Infinity };
  for (let leg = from; leg + 1 < route.length; leg += 1) {
    const distance = distanceToLeg(at, route[leg], route[leg + 1]);
    if (distance < best.distance - 1e-9) best = { leg, distance };
    // Right on the route: what lies beyond is a later visit to the same place.
    if (best.distance < 0.5 && distance > 3) break;
  }
  return best.leg;
}

function distanceToLeg([x, y], [ax, ay], [bx, by]) {
  const [dx, dy] = [bx - ax, by - ay];
  const along = ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1);
  const share = Math.min(1, Math.max(0, along));
  return Math.hypot(x - ax - dx * share, y - ay - dy * share);
}

const overlap = (a, b) =>
  Math.max(0, Math.min(a.x + a.width, b.x + b.width) - Math.max(a.x, b.x)) *
  Math.max(0, Math.min(a.y + a.height, b.y + b.height) - Math.max(a.y, b.y));

/**
 * Puts a label of the given size beside a point, where it covers least of what is in `taken`
 * and stays inside `bounds`; returns its box. All in pixels.
 */
export function placeLabel([x, y], width, height, gap, taken, bounds) {
  const sides = [
    [gap, -height / 2],
    [-gap - width, -height / 2],
    [-width / 2, gap],
    [-width / 2, -gap - height],
    [gap, gap / 2],
    [-gap - width, gap / 2],
    [gap, -gap / 2 - height],
    [-gap - width, -gap / 2 - height],
  ];
  let best = null;
  for (const [dx, dy] of sides) {
    const box = { x: x + dx, y: y + dy, width, height };
    const outside = width * height - overlap(box, bounds);
    const covered = outside * 4 + taken.reduce((sum, other) => sum + overlap(box, other), 0);
    if (!best || covered < best.covered) best = { box, covered };
  }
  return best.box;
}
