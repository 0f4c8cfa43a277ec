// Times and lengths of the procedures.
const table = find("time-table");
const filled = (tag, cells) => {
  const row = made("tr");
  cells.forEach((text, i) => row.append(made(tag, text, i ? "number" : undefined)));
  table.append(row);
};
if (data.times) {
  filled("th", ["procedure", "s", "moves", "mm", "mm/s"]);
  for (const one of data.times.procedures) {
    const mean = one.moving > 0 ? String(Math.round(one.length / one.moving)) : "";
    filled("td", [one.name, one.seconds, String(one.moves), one.length.toFixed(1), mean]);
  }
  filled("td", ["the whole program", data.times.seconds, "", "", ""]);
  table.title = "seconds of a call with all that it calls; its own moves, how far they go, and how fast on the average, each gone through once";
  for (const text of data.times.unknown) find("unknown").append(made("li", text, "where"));
  if (data.times.unknown.length) find("unknown").prepend(made("li", "Not known, or only assumed:", "where"));
} else find("times").hidden = true;
