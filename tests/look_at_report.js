// Tries a page of `report --html`: joined to a copy of it by look_at_report.sh, which reads what it says.
"use strict";
const told = [];
const check = (what, holds) => told.push(`${holds ? "ok" : "FAILED"} ${what}`);
const all = (selector, from = document) => [...from.querySelectorAll(selector)];
const seen = (element) => element.getClientRects().length > 0;
const boxOf = (kind, name) => all(`input[name=${kind}]`).find((box) => box.value === name);
const axes = () => all("figure svg > text").map((text) => `${text.getAttribute("x")} ${text.textContent}`).join("\n");

function filters() {
  const before = axes();
  for (const kind of ["scene", "rays", "tracer"]) {
    const boxes = all(`input[name=${kind}]`);
    const parts = boxes.flatMap((box) => all(`[data-${kind}]`).filter((part) => part.dataset[kind] === box.value).slice(0, 1));
    check(`there are parts of ${kind}s`, boxes.length > 0 && parts.length > 0);
    const name = parts[0].dataset[kind];
    const own = all(`[data-${kind}]`).filter((part) => part.dataset[kind] === name);
    const others = all(`[data-${kind}]`).filter((part) => part.dataset[kind] !== name);
    boxOf(kind, name).click();
    check(`without ${kind} ${name} its ${own.length} parts are gone`, own.every((part) => !seen(part)));
    check(`without it ${others.length} others are not left out`, others.every((part) => !part.classList.contains("out")));
    check("the address says so", new URLSearchParams(location.hash.slice(1)).getAll(`without-${kind}`).join() === name);
    if (kind === "tracer") check("axes stay", axes() === before);
    boxOf(kind, name).click();
    check(`${kind} ${name} is back`, own.every((part) => !part.classList.contains("out")));
  }
  check("the address is empty again", !location.hash.includes("without"));
}

function fronts() {
  const panel = document.querySelector("g.panel");
  if (!panel) { told.push("nothing of fronts"); return; }
  const front = () => all(".mark.front:not(.out)", panel);
  const first = front()[0];
  const line = panel.querySelector(".line").getAttribute("d");
  const name = first.dataset.tracer;
  boxOf("tracer", name).click();
  check(`without ${name} the front is of others`, front().every((mark) => mark.dataset.tracer !== name));
  check("its line follows", panel.querySelector(".line").getAttribute("d") !== line);
  const rest = all(".mark:not(.out)", panel);
  const beats = (one, other) => Number(one.dataset.cost) <= Number(other.dataset.cost) && Number(one.dataset.error) < Number(other.dataset.error);
  check("nobody beats it", front().every((mark) => !rest.some((other) => beats(other, mark))));
  boxOf("tracer", name).click();
  check("it is back as it was", panel.querySelector(".line").getAttribute("d") === line && first.classList.contains("front"));
  first.dispatchEvent(new MouseEvent("mouseover", { bubbles: true }));
  const row = document.getElementById(first.dataset.point);
  const tip = document.getElementById("tip");
  check("a point that is pointed at tells its parameters", !tip.hidden && tip.textContent.includes(row.cells[1].textContent));
  first.dispatchEvent(new MouseEvent("mouseout", { bubbles: true }));
  check("and no longer", tip.hidden);
  const start = panel.querySelector(".mark[tabindex='0']");
  start.focus();
  start.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
  const next = document.activeElement;
  check("arrow keys go from point to point", next !== start && next.classList.contains("mark") && !tip.hidden);
  next.blur();
}

function budgets() {
  const form = document.getElementById("budget");
  if (!form) { told.push("nothing of budgets"); return; }
  const column = (begin) => all("#within thead th").findIndex((head) => head.textContent.startsWith(begin));
  const [take, why] = [column("take"), column("why")];
  const rows = () => all("#within tbody tr").map((row) => [...row.cells].map((cell) => cell.textContent));
  const put = (name, value) => { form.elements[name].value = value; form.dispatchEvent(new Event("input", { bubbles: true })); };
  const needs = all("#answer table").find((table) => table.id !== "within" && table.tHead.textContent.includes("need"));
  const of = (begin) => all("thead th", needs).findIndex((head) => head.textContent.startsWith(begin));
  for (const [value, need] of [["trace", "fastest"], ["mib", "smallest"], ["build", "quickest to build"]]) {
    put("aim", value);
    const said = [...needs.tBodies[0].rows].map((row) => [...row.cells].map((cell) => cell.textContent)).filter((cells) => cells[of("need")] === need);
    check(`whom it takes as ${need} is whom the program takes`, said.length === rows().length && rows().length > 0
      && rows().every((row, index) => row[take].startsWith(said[index][of("take")])));
  }
  check("the address has it", location.hash.includes("budget-aim=build"));
  put("aim", "trace");
  const free = rows();
  const mib = (row) => Number(row[column("structure")].replaceAll(",", ""));
  const half = Math.min(...free.map(mib)) / 2;
  put("mib", half);
  check("fewer bytes leave others, or nobody", rows().every((row, index) => row[take].startsWith("nobody") || (mib(row) <= half && row[take] !== free[index][take])));
  put("mib", 0);
  check("no bytes leave nobody, and say who comes closest and what it lacks", rows().every((row) => row[take].startsWith("nobody; closest: ")
    && /^memory [\d.,]+ MiB where 0 are allowed|^right in .* where /.test(row[why])));
  put("mib", "");
  // The fastest of all is closest to twice its speed, where it is right so often; what it lacks is half of that.
  const speed = (row) => Number(row[column("speed")].replaceAll(",", ""));
  const [most] = free.filter((row) => !row[take].startsWith("nobody")).sort((one, other) => speed(other) - speed(one));
  put("speed", 2 * speed(most));
  const slow = rows().find((row) => row.slice(0, take).join() === most.slice(0, take).join());
  check("too much speed leaves the fastest closest", slow[take] === `nobody; closest: ${most[take]}` && slow[why].startsWith(`speed ${most[column("speed")]} `));
  put("speed", "");
  put("right", 100);
  check("why a point is taken is said", rows().every((row) => row[take].startsWith("nobody") ? / where 100 % are asked/.test(row[why]) : /points? right so often$/.test(row[why])));
  put("right", form.elements.right.defaultValue);
  check("and all is as before", JSON.stringify(rows()) === JSON.stringify(free) && !location.hash.includes("budget"));
  location.hash = "#budget-aim=zzz&budget-right=101&budget-mib=few&budget-pixel=-1";
  recall();
  check("what the address says and nobody can read is as if it were not there", JSON.stringify(rows()) === JSON.stringify(free));
  remember();
  const [name] = free[0][take].replace("nobody; closest: ", "").split(/[ :]/);
  boxOf("tracer", name).click();
  check(`without ${name} another one is taken`, !rows()[0][take].split(/[ :]/).includes(name));
  boxOf("tracer", name).click();
}

function sorting() {
  const table = all("table").find((each) => each.tBodies[0].rows.length > 2 && seen(each));
  const head = all("thead th", table)[0];
  const values = () => [...table.tBodies[0].rows].map((row) => row.cells[0].textContent);
  const count = values().length;
  head.querySelector("button").click();
  const up = values();
  check("a table sorts", head.getAttribute("aria-sort") === "ascending" && up.length === count && up[0].localeCompare(up[count - 1], "en", { numeric: true }) <= 0);
  head.querySelector("button").click();
  check("and the other way", head.getAttribute("aria-sort") === "descending" && values()[0] === up[count - 1]);
}

function pictures() {
  const figure = document.querySelector(".pictures:not(.out)");
  if (!figure) { told.push("nothing of pictures"); return; }
  const shown = () => all("img", figure).filter(seen);
  const select = figure.querySelector("select");
  for (const radio of all("input", figure)) {
    radio.click();
    const [image, ...others] = shown();
    const of = radio.value === "truth" ? undefined : select.value;
    check(`of the pictures ${radio.value} alone is shown`, others.length === 0 && image.dataset.what === radio.value && image.dataset.of === of);
    check("it is as wide as it says", image.naturalWidth === image.width || image.naturalWidth === Number(image.getAttribute("width")));
  }
  const name = select.selectedOptions[0].dataset.tracer;
  boxOf("tracer", name).click();
  check(`without ${name} another point is shown, or none`, shown().every((image) => image.dataset.tracer !== name));
  boxOf("tracer", name).click();
}

function words() {
  for (const line of all(".answer li")) {
    const sets = all("span", line).map((span) => span.dataset.rays);
    sets.forEach((name) => boxOf("rays", name).click());
    check(`without ${sets.join()} nothing is said of whom to take for them`, !seen(line));
    sets.forEach((name) => boxOf("rays", name).click());
    check("with them it is", seen(line));
  }
  check("every chart is named", all("figure svg").every((svg) => svg.getAttribute("aria-label")?.length > 10));
  check("every chart names its machine", all("figcaption").every((caption) => caption.textContent.includes("threads;")));
  check("nothing is fetched", performance.getEntriesByType("resource").length === 0);
  check("nothing is wider than the page", document.documentElement.scrollWidth <= innerWidth);
}

for (const part of [filters, fronts, budgets, sorting, pictures, words]) part();
told.push("ok all");
const pre = document.createElement("pre");
pre.id = "probe";
pre.textContent = `\n${told.join("\n")}\n`;
document.body.append(pre);
