// How states, times and places are said to people.

const PILES = {
  free: "free",
  reserved: "reserved",
  charging: "charging",
  done: "done",
  fault: "fault",
  unknown: "unknown",
};

const ROBOTS = {
  working: "working",
  waiting: "waiting",
  approaching: "to",
  docked: "at",
  charging: "on",
  stranded: "stranded",
  unknown: "unknown",
};

const STAGES = {
  reach_all: "every idle pile is within reach",
  reach_some: "some idle piles are within reach",
  almost_charged: "only almost charged piles are within reach",
  nearest: "the nearest free pile",
  together: "the least time away from work for all robots that wait",
  later: "it is best to wait for a pile that is still occupied",
  preempting: "the robot is critical: another's charge is cut short",
  none: "no usable pile is within reach",
};

/** A word of the API as people write it: one this page does not know is shown, not hidden. */
export const plain = (word) => String(word ?? "unknown").replaceAll("_", " ");
export const stage = (word) => STAGES[word] ?? plain(word);

/** Which of the states that this page can draw; any other is unknown. */
export const pileState = (pile) =>
  Object.hasOwn(PILES, pile.availability) ? pile.availability : "unknown";
export const robotState = (robot) =>
  Object.hasOwn(ROBOTS, robot.activity) ? robot.activity : "unknown";

/** A robot's battery; null before its first word, when the API can only say 0. */
export const battery = (robot) => (robot.at ? robot.battery : null);

const known = (value) => typeof value === "number" && Number.isFinite(value);
export const number = (value, digits = 1) => (known(value) ? value.toFixed(digits) : "–");
export const percent = (fraction) => (known(fraction) ? `${Math.round(fraction * 100)} %` : "?");

/** Seconds, as long as needed: 0.3 s, 42 s, 3:05 min, 2:10:00 h. */
export function duration(seconds) {
  if (!known(seconds)) return "–";
  if (seconds > 0 && seconds < 9.95) return `${seconds.toFixed(1)} s`;
  const whole = Math.max(0, Math.round(seconds));
  if (whole < 60) return `${whole} s`;
  return whole < 3600 ? `${clockFace(whole).slice(3).replace(/^0/, "")} min` : `${clockFace(whole)} h`;
}

function clockFace(seconds) {
  const two = (n) => String(Math.floor(n)).padStart(2, "0");
  return `${two(seconds / 3600)}:${two((seconds / 60) % 60)}:${two(seconds % 60)}`;
}

// A real site counts from 1970, a simulated one from its start; no simulation runs 30 years.
const REAL_TIME_MS = 1e12;

/** The site's time: the time of day of a real site, the time since the start of a simulated one. */
export function clock(ms) {
  if (!known(ms)) return "–";
  return ms < REAL_TIME_MS ? clockFace(ms / 1000) : new Date(ms).toLocaleTimeString("en-GB");
}

/** A cell in the site's own frame. */
export function place(site, at) {
  if (!at) return "place unknown";
  const { origin, y_up: yUp } = site.frame;
  const x = Math.round(at[0]) + origin;
  const y = (yUp ? site.height - 1 - Math.round(at[1]) : Math.round(at[1])) + origin;
  return `(${x}, ${y})`;
}

/** One line on what a pile does. */
export function pileLine(pile) {
  const state = pileState(pile);
  if (state === "charging") {
    const left = known(pile.planned_s) && known(pile.elapsed_s) ? pile.planned_s - pile.elapsed_s : null;
    return `charging, ${percent(pile.remaining)} to go${left > 0 ? `, ${duration(left)}` : ""}`;
  }
  if (state === "fault") return `fault: ${pile.faults?.map(plain).join(", ") || "no cause given"}`;
  return { ...PILES, done: "done, robot still there", unknown: "unknown, silent too long" }[state];
}

const HELPS = {
  queued: () => "waits for a mobile charger",
  coming: ({ charger }) => `R${charger} is on its way`,
  charging: ({ charger }) => `R${charger} charges it`,
  tow: ({ reason }) => `has to be towed: ${reason ?? "no cause given"}`,
};

/** One line on a robot that can't come to a pile, and its help. */
export function helpLine(help) {
  const plight = help.plight === "out_of_reach" ? "no pile is in its reach" : plain(help.plight);
  const stage = Object.hasOwn(HELPS, help.stage) ? HELPS[help.stage](help) : plain(help.stage);
  return `R${help.robot}: ${plight}, ${stage}`;
}

/** One line on what a robot does. */
export function robotLine(robot) {
  const state = robotState(robot);
  if (!["approaching", "docked", "charging"].includes(state)) return ROBOTS[state];
  return robot.pile == null ? state : `${ROBOTS[state]} pile ${robot.pile}`;
}
