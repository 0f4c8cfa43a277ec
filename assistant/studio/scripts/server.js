// What is asked of the studio: plain data there and back; what is refused comes as findings.
import { word } from "./words.js";

let window_ = "";
export const nameWindow = (name) => { window_ = name; };

export class Refused extends Error {
  constructor(findings) {
    super(findings[0]?.message ?? "");
    this.findings = findings;
  }
}
async function answered(asked) {
  const response = await asked.catch(() => { throw new Refused([{ severity: "error", code: "", message: word("not_answered") }]); });
  const answer = await response.json().catch(() => ({ findings: [] }));
  if (!response.ok) throw new Refused(answer.findings ?? []);
  return answer;
}
export async function look(path, values = {}) {
  const query = new URLSearchParams(values).toString();
  return answered(fetch(`${path}${query ? `?${query}` : ""}`, { headers: { "X-Window": window_ } }));
}
export async function ask(path, values = {}) {
  return answered(fetch(path, {
    method: "POST", headers: { "Content-Type": "application/json", "X-Window": window_ }, body: JSON.stringify(values),
  }));
}
export async function send(path, values, data) {
  return answered(fetch(`${path}?${new URLSearchParams(values)}`, {
    method: "POST", headers: { "Content-Type": "application/octet-stream", "X-Window": window_ }, body: data,
  }));
}
