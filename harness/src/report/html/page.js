// Leaving out: every part says in data-scene, data-rays and data-tracer what it belongs to. The address holds what is left out.
const form = document.getElementById("choice");
const KINDS = ["scene", "rays", "tracer"];
const tagged = [...document.querySelectorAll("[data-scene], [data-rays], [data-tracer]")];

function leftOut() {
  const out = {};
  for (const kind of KINDS) {
    const boxes = [...form.querySelectorAll(`input[name=${kind}]`)];
    out[kind] = new Set(boxes.filter((box) => !box.checked).map((box) => box.value));
    const shown = boxes.length - out[kind].size;
    const output = boxes[0]?.closest("details").querySelector("output");
    if (output) output.textContent = `${shown} of ${boxes.length}`;
  }
  return out;
}

function show() {
  const out = leftOut();
  for (const part of tagged) {
    part.classList.toggle("out", KINDS.some((kind) => out[kind].has(part.dataset[kind])));
  }
  document.querySelectorAll("g.panel").forEach(redraw);
  document.querySelectorAll(".pictures").forEach(picture);
  document.querySelectorAll(".player").forEach(frame);
  if (budget) within(out);
}

function remember() {
  const parameters = new URLSearchParams();
  const out = leftOut();
  for (const kind of KINDS) out[kind].forEach((name) => parameters.append(`without-${kind}`, name));
  for (const field of budget?.elements ?? []) if (field.value !== own(field)) parameters.set(`budget-${field.name}`, field.value);
  history.replaceState(null, "", `#${parameters}`);
}

function recall() {
  const parameters = new URLSearchParams(location.hash.slice(1));
  for (const kind of KINDS) {
    const out = new Set(parameters.getAll(`without-${kind}`));
    form.querySelectorAll(`input[name=${kind}]`).forEach((box) => { box.checked = !out.has(box.value); });
  }
  for (const field of budget?.elements ?? []) fill(field, parameters.get(`budget-${field.name}`));
  show();
}

// The front of those that are shown: whom none beats. Who beats whom by noise alone is in data-near.
function redraw(panel) {
  const marks = [...panel.querySelectorAll(".mark:not(.out)")].map((element) => ({
    element,
    index: element.dataset.index,
    cost: Number(element.dataset.cost),
    error: Number(element.dataset.error),
    near: new Set((element.dataset.near || "").split(" ")),
  }));
  const beats = (one, other) =>
    one.cost <= other.cost && one.error <= other.error && (one.cost < other.cost || one.error < other.error);
  const front = marks.filter((mark) => !marks.some((other) => beats(other, mark)));
  for (const mark of marks) {
    const above = front.filter((other) => beats(other, mark));
    const standing = above.length === 0 ? "front" : above.every((other) => mark.near.has(other.index)) ? "noise" : "behind";
    mark.element.classList.remove("front", "noise", "behind");
    mark.element.classList.add(standing);
  }
  front.sort((one, other) => one.cost - other.cost || other.error - one.error);
  let path = "";
  for (const mark of front) {
    const { e: x, f: y } = mark.element.transform.baseVal.consolidate().matrix;
    path += path ? `H${x}V${y}` : `M${x} ${y}`;
  }
  panel.querySelector(".line").setAttribute("d", path);
  const first = panel.querySelector(".mark:not(.out)[tabindex='0']");
  if (!first && marks.length) marks[0].element.setAttribute("tabindex", "0");
}

form.addEventListener("change", () => { show(); remember(); });
form.addEventListener("reset", () => setTimeout(() => { show(); remember(); }));
window.addEventListener("hashchange", () => { if (/without-|budget-/.test(location.hash)) recall(); });
document.addEventListener("click", (event) => {
  for (const open of form.querySelectorAll("details[open]")) if (!open.contains(event.target)) open.open = false;
  const link = event.target.closest("a[href^='#']");
  if (!link) return;
  event.preventDefault();
  document.querySelector(link.getAttribute("href"))?.scrollIntoView();
});

// Points tell what they are when they are pointed at or have the focus; arrow keys go from one to the next.
const tip = document.getElementById("tip");
function tell(mark) {
  const row = document.getElementById(mark.dataset.point);
  const standing = { front: "on the front of those shown", noise: "within noise of the front", behind: "behind the front" };
  const kind = Object.keys(standing).find((name) => mark.classList.contains(name));
  tip.replaceChildren(mark.getAttribute("aria-label"));
  for (const text of [standing[kind], row && `${row.cells[1].textContent}; frame, faces ${row.cells[2].textContent}`]) {
    const line = document.createElement("small");
    line.textContent = text || "";
    tip.append(line);
  }
  tip.hidden = false;
  const { left, top, bottom } = mark.querySelector(".dot").getBoundingClientRect();
  const { width, height } = tip.getBoundingClientRect();
  tip.style.left = `${Math.max(4, Math.min(left + 12, innerWidth - width - 4))}px`;
  tip.style.top = `${bottom + height + 12 > innerHeight ? Math.max(4, top - height - 8) : bottom + 8}px`;
}
for (const [begin, end] of [["mouseover", "mouseout"], ["focusin", "focusout"]]) {
  document.addEventListener(begin, (event) => { const mark = event.target.closest?.(".mark"); if (mark) tell(mark); });
  document.addEventListener(end, (event) => { if (event.target.closest?.(".mark")) tip.hidden = true; });
}
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") tip.hidden = true;
  const mark = event.target.closest?.(".mark");
  const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
  if (!mark || !step) return;
  event.preventDefault();
  const x = (of) => of.transform.baseVal.consolidate().matrix.e;
  const marks = [...mark.closest(".panel").querySelectorAll(".mark:not(.out)")].sort((one, other) => x(one) - x(other));
  const next = marks[(marks.indexOf(mark) + step + marks.length) % marks.length];
  mark.setAttribute("tabindex", "-1");
  next.setAttribute("tabindex", "0");
  next.focus();
});

// Of the pictures of a figure one is shown: the truth, or what is chosen of a point.
function picture(figure) {
  const select = figure.querySelector("select");
  if (select.selectedOptions[0]?.classList.contains("out")) {
    const left = [...select.options].find((option) => !option.classList.contains("out"));
    if (left) select.value = left.value;
  }
  const what = figure.querySelector("input:checked").value;
  figure.querySelector(".key").hidden = what !== "class";
  for (const image of figure.querySelectorAll("img")) {
    image.hidden = image.dataset.what !== what || (image.dataset.of ?? select.value) !== select.value;
  }
}
document.addEventListener("change", (event) => {
  const figure = event.target.closest?.(".pictures");
  if (figure) picture(figure);
});

// Of the frames of a player one is shown: of the truth, or of a tracer's answer or error. Stills of a sheet are four pixels apart.
function frame(figure) {
  const select = figure.querySelector("select");
  if (select.selectedOptions[0]?.classList.contains("out")) select.value = "truth";
  const [error, range] = figure.querySelectorAll("input");
  const { width, height } = figure.dataset;
  const screen = figure.querySelector(".screen");
  screen.style.width = `${width}px`;
  screen.style.height = `${height}px`;
  figure.querySelector("output").value = range.value;
  for (const image of screen.querySelectorAll("img")) {
    image.hidden = image.dataset.of !== select.value;
    const { rows, columns } = image.dataset;
    const row = Math.floor(range.value / columns) * rows + (rows > 1 && error.checked ? 1 : 0);
    image.style.left = `${-(range.value % columns) * (+width + 4)}px`;
    image.style.top = `${-row * (+height + 4)}px`;
  }
}
for (const figure of document.querySelectorAll(".player")) {
  const [, range] = figure.querySelectorAll("input");
  let timer = 0;
  figure.addEventListener("input", () => frame(figure));
  figure.querySelector("button").addEventListener("click", (event) => {
    clearInterval(timer);
    timer = timer ? 0 : setInterval(() => {
      range.value = +range.value < +range.max ? +range.value + 1 : 0;
      frame(figure);
    }, Math.max(40, 1000 / figure.dataset.fps));
    event.target.textContent = timer ? "Stop" : "Play";
  });
}

// Where rows are cards, every cell has its heading.
for (const table of document.querySelectorAll("#answer table:not(#within)")) {
  const heads = [...table.tHead.rows[0].cells].map((head) => head.textContent);
  for (const row of table.tBodies[0].rows) [...row.cells].forEach((cell, column) => { cell.dataset.head = heads[column]; });
}

// Tables sort by what their cells begin with: as numbers where most are.
function key(cell) {
  const text = (cell?.textContent || "").replace(/^[^\p{L}\p{N}+-]+/u, "").trim();
  const found = text.replace(/(\d),(?=\d{3})/g, "$1").match(/^[^:]*: (.*)$|^(.*)$/);
  const number = parseFloat((found?.[2] ?? found?.[1] ?? "").replace("−", "-"));
  return { text, number };
}
for (const table of document.querySelectorAll("table")) {
  const heads = [...table.querySelectorAll("thead th")];
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      const body = table.tBodies[0];
      const rows = [...body.rows].map((row) => ({ row, ...key(row.cells[column]) }));
      const numbers = rows.filter(({ number }) => !Number.isNaN(number)).length * 2 > rows.length;
      const sign = up ? 1 : -1;
      rows.sort((one, other) => {
        if (!numbers) return sign * one.text.localeCompare(other.text, "en", { numeric: true });
        // What has no number is last either way.
        const none = Number.isNaN(one.number) - Number.isNaN(other.number);
        return none || sign * (one.number - other.number) || 0;
      });
      body.append(...rows.map(({ row }) => row));
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
    });
  });
}
recall();
