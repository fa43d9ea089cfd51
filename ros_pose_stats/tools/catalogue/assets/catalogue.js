"use strict";
// Rows are arrays, as page.py writes them; those of parts that were refused end after the reason.
const FIELDS = ["file", "refusal", "picture", "report", "made", "declared", "guessed", "triangles", "size", "poses", "distinct",
  "method", "drops", "error", "largest", "share", "shareLow", "shareHigh", "entropy", "passes", "passesLow",
  "passesHigh", "length", "width", "top", "warnings", "notes", "groups"];
const AT_ONCE = 100;
const parts = [];
const FIRST = { by: "share", falling: true };
let shown = [], limit = AT_ONCE, sorted = FIRST;

const headingOf = ([code]) => settings.headings[code];
const inWords = warning => `${headingOf(warning)}: ${warning[1]}`.replace("?:", "?");

function addRows(rows) {
  for (const row of rows) {
    const part = { warnings: [], notes: [], groups: [] };
    row.forEach((value, k) => { part[FIELDS[k]] = value; });
    part.warned = part.warnings.length;  // to sort by
    const notes = [...part.warnings, ...part.notes];
    part.words = [part.file, part.refusal, ...notes.flat(), ...notes.map(headingOf)].join("\n").toLowerCase();
    parts.push(part);
  }
}

const twoDecimals = value => value == null ? "–" : value < 100 ? value.toFixed(2) : number(value);
const number = (value, digits = 3) =>
  value == null ? "–" : String(Number(value.toPrecision(digits)));
const percent = value => value == null ? "–" : (100 * value).toFixed(1) + "\u00a0%";
const millimetres = (...values) => `${values.map(x => number(x)).join(" × ")}\u00a0mm`;
const between = (low, high, show) =>
  low == null || high == null ? "" : `${show(low).replace("\u00a0%", "")} to ${show(high)}`;
const element = (name, content = "", kind = "") => {
  const made = document.createElement(name);
  if (kind) made.className = kind;
  made.append(...(Array.isArray(content) ? content : [content]));
  return made;
};

const COLUMNS = [
  { name: "Part", by: "file", kind: "part left", cell: partCell },
  { name: "Poses", by: "distinct", cell: p => [String(p.distinct), element("small", `(${p.poses})`)] },
  { name: "Best pose", by: "share", falling: true, cell: shareCell },
  { name: "Drops for each accepted part", by: "passes", cell: p => [twoDecimals(p.passes),
    element("small", between(p.passesLow, p.passesHigh, twoDecimals))] },
  { name: "Entropy", by: "entropy", cell: p => [twoDecimals(p.entropy), "\u00a0bit"] },
  { name: "Footprint", by: "length", unit: "mm", cell: p => [millimetres(p.length, p.width)] },
  { name: "Height", by: "top", unit: "mm", cell: p => [millimetres(p.top)] },
  { name: "Error", by: "error", cell: p => [p.error == null ? "–" : `${number(100 * p.error, 2)}\u00a0points`,
    element("small", p.drops ? `${p.drops} drops` : "estimated")] },
  { name: "Warnings", by: "warned", falling: true, kind: "notes left", cell: warningsCell },
];

function partCell(part) {
  const at = part.file.lastIndexOf("/") + 1;
  const open = element("button", part.file.slice(at));
  open.type = "button";
  open.setAttribute("aria-expanded", "false");
  return [open, element("small", part.file.slice(0, at))];
}

function warningsCell(part) {
  return part.warnings.map(warning => element("div", headingOf(warning), "warned"));
}

function shareCell(part) {
  const bar = element("span", "", "bar");
  const fill = element("i"), range = element("b");
  fill.style.width = `${100 * (part.share ?? 0)}%`;
  bar.append(fill);
  if (part.shareLow != null) {
    range.style.left = `${100 * part.shareLow}%`;
    range.style.width = `${100 * (part.shareHigh - part.shareLow)}%`;
    bar.append(range);
  }
  return [percent(part.share), bar, element("small", between(part.shareLow, part.shareHigh, percent))];
}

function rowOf(part) {
  const row = element("tr"), picture = element("td", "", "picture");
  if (part.picture) {
    const image = element("img");
    Object.assign(image, { loading: "lazy", alt: "", src: part.picture, width: 88 });
    picture.append(image);
    row.className = "has-picture";
  }
  row.append(picture);
  for (const column of COLUMNS) {
    if (part.refusal && column.by !== "file") continue;
    const cell = element("td", column.cell(part), column.kind ?? "");
    if (column.by !== "file") cell.dataset.name = column.name;
    if (column.by === "warned" && !part.warned) delete cell.dataset.name;
    row.append(cell);
  }
  if (part.refusal) {
    const cell = element("td", `refused: ${part.refusal}`, "refused left");
    cell.colSpan = COLUMNS.length - 1;
    row.append(cell);
  }
  row.querySelector(".part button").onclick = event => turnOver(event.target, row, part);
  return row;
}

function turnOver(button, row, part) {
  const open = row.nextSibling?.className === "more";
  if (open) row.nextSibling.remove();
  else row.after(detailsOf(part));
  button.setAttribute("aria-expanded", String(!open));
}

function detailsOf(part) {
  const cell = element("td");
  cell.colSpan = COLUMNS.length + 1;
  if (!part.refusal) {
    const size = millimetres(...part.size) + (part.guessed && ` if the file is in ${part.guessed}, which is a guess`);
    cell.append(element("p", `${size}, ${part.triangles} triangles; `
      + (part.drops ? `${part.drops} drops (${part.method})` : `estimated (${part.method})`)
      + (part.largest == null ? "" : `; with 90 % confidence no pose is off by more than ${number(100 * part.largest, 2)} points`)),
    element("h3", "Poses"), posesOf(part));
  }
  for (const warning of part.warnings) cell.append(element("p", inWords(warning), "warning"));
  for (const note of part.notes) cell.append(element("p", inWords(note), "soft"));
  cell.append(element("h3", "Report with pictures of all poses"), ...reportOf(part));
  const row = element("tr", [cell], "more");
  return row;
}

function posesOf(part) {
  const heads = ["Pose", "Share", "90 % interval", "Footprint", "Height", "Tilt to topple"];
  const head = element("tr", heads.map(name => element("th", name)));
  const rows = part.groups.map(([named, share, low, high, length, width, top, margin, rolls]) => element("tr", [
    named + (rolls ? ", rolls" : ""), percent(share), between(low, high, percent),
    millimetres(length, width), millimetres(top), margin == null ? "–" : `${number(margin)}°`,
  ].map((text, k) => {
    const cell = element("td", text);
    cell.dataset.name = heads[k];
    return cell;
  })));
  const table = element("table", [element("thead", [head]), element("tbody", rows)]);
  const more = part.distinct - part.groups.length;
  return more > 0 ? element("div", [table, element("p", `${more} more in poses.csv`, "soft")]) : table;
}

const quoted = word => /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\"'\"'")}'`;

function reportOf(part) {
  if (part.refusal) return [element("p", "None: the part was refused.")];
  const link = element("a", part.made ? "Open the report" : "open it");
  link.href = encodeURI(part.report).replaceAll("#", "%23").replaceAll("?", "%3F");
  if (part.made) return [element("p", [link])];
  const words = ["ros_pose_stats", "report", `${settings.parts}/${part.file}`, ...(part.declared ? [] : settings.unit),
    ...settings.options, "-o", `${settings.folder}/${part.report}`];
  const code = element("code", words.map(quoted).join(" ")), copy = element("button", "Copy");
  copy.type = "button";
  copy.onclick = () => {
    getSelection().selectAllChildren(code);
    document.execCommand("copy");
    copy.textContent = "Copied";
  };
  return [element("p", ["Make it with this command, then ", link, ":"]), element("div", [code, copy], "command")];
}

const field = id => document.getElementById(id);
const limitOf = id => field(id).value === "" ? null : Number(field(id).value);

function fits(part, length, width, top) {
  const [long, short] = [length ?? Infinity, width ?? Infinity].sort((a, b) => b - a);
  return part.length <= long && part.width <= short && part.top <= (top ?? Infinity);
}

function wanted() {
  const words = field("words").value.toLowerCase().split(/\s+/).filter(Boolean);
  const kind = field("kind").value, share = limitOf("share"), passes = limitOf("passes");
  const box = ["fit-length", "fit-width", "fit-top"].map(limitOf), boxed = box.some(x => x != null);
  const kinds = { all: () => true, answered: p => !p.refusal, refused: p => !!p.refusal,
    clean: p => !p.refusal && !p.warned, warned: p => p.warned > 0 };
  const shows = kinds[kind] ?? (p => p.warnings.some(([code]) => code === kind));
  return part => shows(part) && words.every(word => part.words.includes(word))
    && (share == null || 100 * part.share >= share) && (passes == null || part.passes <= passes)
    && (!boxed || fits(part, ...box));
}

const names = new Intl.Collator(undefined, { numeric: true });

function order(by, falling) {
  const sign = falling ? -1 : 1;
  if (by === "file") return (a, b) => sign * names.compare(a.file, b.file);
  const value = by === "warned" ? part => part.refusal ? null : part.warned : part => part[by];
  return (a, b) => {  // what is not known comes last in both directions
    const x = value(a), y = value(b);
    return (x == null) - (y == null) || sign * (x - y) || 0;
  };
}

function refresh() {
  limit = AT_ONCE;
  shown = parts.filter(wanted()).sort(order(sorted.by, sorted.falling));
  document.querySelectorAll("thead th[data-by]").forEach(head => {
    if (head.dataset.by === sorted.by) head.setAttribute("aria-sort", sorted.falling ? "descending" : "ascending");
    else head.removeAttribute("aria-sort");
  });
  field("sort").value = sorted.by;
  field("descending").checked = sorted.falling;
  document.querySelector("#parts > tbody").replaceChildren();
  fill(0);
}

function fill(from) {
  document.querySelector("#parts > tbody").append(...shown.slice(from, limit).map(rowOf));
  field("count").textContent = `${shown.length} of ${parts.length} parts`
    + (shown.length > limit ? `, the first ${limit} shown` : "");
  field("more").hidden = shown.length <= limit;
  field("more").textContent = `Show ${Math.min(AT_ONCE, shown.length - limit)} more`;
}

function sortBy(by, falling) {
  sorted = { by, falling };
  refresh();
}

function begin() {
  const heads = document.querySelector("#parts > thead > tr");
  heads.append(element("th"));
  for (const column of COLUMNS) {
    const button = element("button", column.name), head = element("th", [button], column.kind ?? "");
    button.type = "button";
    button.onclick = () => sortBy(column.by,
      sorted.by === column.by ? !sorted.falling : !!column.falling);
    head.dataset.by = column.by;
    head.scope = "col";
    heads.append(head);
    const option = element("option", column.name.toLowerCase());
    option.value = column.by;
    field("sort").append(option);
  }
  field("sort").onchange = event => sortBy(event.target.value,
    !!COLUMNS.find(one => one.by === event.target.value).falling);
  field("descending").onchange = event => sortBy(sorted.by, event.target.checked);
  field("more").onclick = () => { const from = limit; limit += AT_ONCE; fill(from); };
  const form = field("filters");
  form.onsubmit = event => event.preventDefault();
  form.oninput = event => { if (!event.target.closest(".sort")) refresh(); };
  document.querySelectorAll("#concerns button").forEach(button => {
    button.onclick = () => {
      field("kind").value = button.dataset.kind;
      refresh();
      form.scrollIntoView();
    };
  });
  form.onreset = () => setTimeout(() => sortBy(FIRST.by, FIRST.falling));
  refresh();
}
