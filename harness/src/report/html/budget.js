"use strict";
// Whom a budget leaves: of every case the point that costs least of what is asked for; where none is left, who comes closest.
const budget = document.getElementById("budget");
const own = (field) => field.defaultValue ?? field.options[0].value;
const cases = budget ? JSON.parse(document.getElementById("budget-points").textContent) : [];
const short = (number, digits = 4) => number.toLocaleString("en", { maximumSignificantDigits: digits });

// What cannot be read is as if it had not been given.
function fill(field, given) {
  const isNumber = /^(-?\d*\.?\d+(e[-+]?\d+)?)?$/i.test(given) && Number.isFinite(Number(given));
  const isRead = field.options ? [...field.options].some(({ value }) => value === given) : isNumber;
  field.value = isRead ? given : own(field);
  if (!field.checkValidity()) field.value = own(field);
}

// Limits on what a point costs: how many times over a point is, and what it has where how much is allowed.
function limits() {
  return [...budget.querySelectorAll("[data-said]")].filter(({ value }) => value !== "").map(({ name, value, dataset: { said, unit } }) => {
    const limit = Number(value);
    const [over, verb] = name === "speed" ? [(point) => limit / point.speed, "asked"] : [(point) => point[name] / limit, "allowed"];
    const told = (point) => {
      // As many digits as tell it from the limit.
      const digits = [4, 6, 9, 17].find((digits) => Number(point[name].toPrecision(digits)) !== limit);
      return `${said} ${short(point[name], digits)} ${unit} where ${short(limit, 17)} are ${verb}`;
    };
    return { over, told };
  });
}

// Of some points whom to take, or who comes closest, and why.
function taken(all, limits, right, aim) {
  // A share of whole rays that is just so counts.
  const isEnough = (point) => point.right >= right / 100 - 1e-12;
  const broken = (point) => limits.filter(({ over }) => over(point) > 1);
  const worst = (point) => Math.max(0, ...broken(point).map(({ over }) => over(point)));
  const least = (of, ...by) => of.reduce((best, point) => {
    const step = best && by.map((cost) => [cost(best), cost(point)]).find(([one, other]) => one !== other);
    return !best || (step && step[1] < step[0]) ? point : best;
  }, null);
  const cost = (point) => point[aim.value];
  const enough = all.filter(isEnough);
  const affordable = all.filter((point) => broken(point).length === 0);
  const both = affordable.filter(isEnough);
  const within = limits.length ? "within the limits" : "right so often";
  if (both.length) {
    const name = aim.selectedOptions[0].textContent;
    return { point: least(both, cost), first: "", why: both.length === 1 ? `the only point ${within}` : `${name} of ${both.length} points ${within}` };
  }
  const first = "nobody; closest: ";
  if (enough.length) {
    const point = least(enough, worst, cost);
    const other = least(affordable, ({ right }) => -right, cost);
    const rest = other ? [`within the limits the most often right is ${other.label}: ${other.told}`] : [];
    return { point, first, why: [...broken(point).map(({ told }) => told(point)), ...rest].join("; ") };
  }
  if (!all.length) return { point: null, first: "nobody", why: "no point is shown" };
  const point = least(affordable.length ? affordable : all, ({ right }) => -right, worst, cost);
  const why = [`right in ${point.told} where ${short(right, 17)} % are asked`, ...broken(point).map(({ told }) => told(point))];
  return { point, first, why: why.join("; ") };
}

function within(out) {
  const { right, pixel, aim } = budget.elements;
  const asked = limits();
  const rows = [];
  for (const { scene, rays, machine, record, by, count, pixels, points } of cases) {
    if (out.scene.has(scene) || out.rays.has(rays)) continue;
    const all = points.filter(([tracer]) => !out.tracer.has(tracer)).map(([, label, right, told, trace, build, mib]) => {
      const frame = build + (Number(pixel.value) * pixels / count) * trace;
      return { label, right, told, trace, build, mib, frame, speed: count / (trace * 1e3) };
    });
    const { point, first, why } = taken(all, asked, Number(right.value), aim);
    const costs = point ? [point.mib, point.build, point.frame, point.speed].map((cost) => short(cost)) : Array(4).fill("–");
    rows.push([rays, scene, machine, ...(record === null ? [] : [record]), first + (point?.label ?? ""), point ? `${point.told} by ${by}` : "–", ...costs, why]);
  }
  const table = document.getElementById("within");
  const heads = [...table.tHead.rows[0].cells].map((head) => head.textContent);
  table.tBodies[0].replaceChildren(...rows.map((texts) => {
    const row = document.createElement("tr");
    texts.forEach((text, column) => {
      const cell = row.insertCell();
      cell.dataset.head = heads[column];
      cell.textContent = text;
    });
    return row;
  }));
}
budget?.addEventListener("input", () => { within(leftOut()); remember(); });
budget?.addEventListener("submit", (event) => event.preventDefault());
