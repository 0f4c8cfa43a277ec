// Tabs: by mouse, finger, or arrow keys.
import { find } from "./words.js";

export function choose(id) {
  const tab = find(id), tabs = [...tab.parentElement.children];
  for (const one of tabs) {
    const on = one === tab;
    one.setAttribute("aria-selected", String(on));
    one.tabIndex = on ? 0 : -1;
    find(one.getAttribute("aria-controls")).hidden = !on;
  }
  tab.dispatchEvent(new CustomEvent("chosen", { bubbles: true }));
}
export function beginTabs() {
  for (const list of document.querySelectorAll("[role=tablist]")) {
    const tabs = [...list.children];
    tabs.forEach((tab, i) => {
      tab.tabIndex = i ? -1 : 0;
      tab.addEventListener("click", () => choose(tab.id));
    });
    list.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      const next = tabs[(tabs.indexOf(document.activeElement) + step + tabs.length) % tabs.length];
      choose(next.id);
      next.focus();
    });
  }
  document.addEventListener("keydown", (event) => {
    const ids = ["tab-text", "tab-drawing", "tab-scene", "tab-run", "tab-controller"];
    if (!event.altKey || event.ctrlKey || !/^[1-6]$/.test(event.key)) return;
    event.preventDefault();
    if (event.key === "6") { find("drop").focus(); return; }
    const id = ids[Number(event.key) - 1];
    choose(id);
    find(id).focus();
  });
}
