// Beginning: words, the line to the studio, and each part of the page.
import { beginWords, find } from "./words.js";
import { beginLine } from "./line.js";
import { beginTabs } from "./tabs.js";
import { beginPanes } from "./panes.js";
import { beginFindings } from "./findings.js";
import { beginProject, chooseFile, readProject } from "./project.js";
import { beginDrawing } from "./drawing.js";
import { beginEditor, goToFinding } from "./editor.js";
import { beginScene } from "./scene.js";
import { beginRun } from "./run.js";
import { beginController } from "./controller.js";
import { beginControl } from "./control.js";

beginWords();
beginTabs();
beginPanes();
const theme = localStorage.getItem("theme");
if (theme) document.documentElement.classList.add(theme);
find("theme").addEventListener("click", () => {
  const dark = document.documentElement.classList.contains("dark")
    || (!document.documentElement.classList.contains("light") && matchMedia("(prefers-color-scheme: dark)").matches);
  document.documentElement.classList.remove("dark", "light");
  document.documentElement.classList.add(dark ? "light" : "dark");
  localStorage.setItem("theme", dark ? "light" : "dark");
  find("theme").dispatchEvent(new Event("themed"));
});
beginProject();
beginDrawing();
beginEditor();
beginScene();
beginRun();
beginController();
beginControl();
beginFindings((finding) => goToFinding(finding, chooseFile));
await beginLine();
await readProject();
document.body.classList.add("ready");
