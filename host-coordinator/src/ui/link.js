// The WebSocket of changes: kept open, reopened with growing pauses, never trusted to be alive.

const FIRST_PAUSE_MS = 500;
const LONGEST_PAUSE_MS = 15_000;
// A connection can die without a word. After this silence a new one brings the whole state again.
const SILENCE_MS = 20_000;

/**
 * Calls `onMessage(message)` for every message and `onLink(link)` whenever the link's state
 * changes: "connecting", "live", or "lost" with `retryAt`, the time of the next attempt.
 */
export function connect(path, onMessage, onLink) {
  let pause = FIRST_PAUSE_MS;

  function open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}${path}`);
    let watchdog;
    const heard = () => {
      clearTimeout(watchdog);
      watchdog = setTimeout(giveUp, SILENCE_MS);
    };
    const giveUp = () => {
      if (socket.onmessage === null) return;
      socket.onmessage = socket.onclose = null;
      clearTimeout(watchdog);
      socket.close();
      const wait = pause * (0.75 + Math.random() / 2);
      pause = Math.min(pause * 2, LONGEST_PAUSE_MS);
      onLink({ state: "lost", retryAt: Date.now() + wait });
      setTimeout(open, wait);
    };
    socket.onmessage = ({ data }) => {
      let message;
      try {
        message = JSON.parse(data);
      } catch {
        giveUp();
        return;
      }
      heard();
      if (message.type === "state") {
        pause = FIRST_PAUSE_MS;
        onLink({ state: "live" });
      }
      onMessage(message);
    };
    socket.onclose = giveUp;
    heard();
  }

  onLink({ state: "connecting" });
  open();
}
