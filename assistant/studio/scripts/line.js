// The line to the studio: who writes, what changed on the disk, and what goes on there.
import { find, word } from "./words.js";
import { nameWindow } from "./server.js";

const heard = new Map();
let line = null;
export const state = { writes: false, name: "" };

/** Calls that for each message of a kind. */
export function on(kind, does) {
  heard.set(kind, [...(heard.get(kind) ?? []), does]);
}
export function say(message) {
  if (line?.readyState === WebSocket.OPEN) line.send(JSON.stringify(message));
}
function tell(kind, message) {
  for (const does of heard.get(kind) ?? []) does(message);
}
export function beginLine() {
  return new Promise((resolve) => {
    const address = new URL("window", location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    line = new WebSocket(address);
    line.addEventListener("message", (event) => {
      const message = JSON.parse(event.data);
      if (message.kind === "window") {
        Object.assign(state, { writes: message.writes, name: message.name });
        nameWindow(message.name);
        find("who").dataset.word = message.writes ? "writes" : "read_only";
        find("who").textContent = word(find("who").dataset.word);
        document.body.classList.toggle("reads", !message.writes);
        resolve();
      }
      tell(message.kind, message);
    });
    line.addEventListener("close", () => {
      state.writes = false;
      find("who").dataset.word = "lost";
      find("who").textContent = word("lost");
      tell("lost", {});
      resolve();
    });
  });
}
