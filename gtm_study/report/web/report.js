"use strict";

/** Buttons that sort a table by a column, and one that downloads it. */
for (const table of document.querySelectorAll("table.sortable")) {
  [...table.tHead.rows[0].cells].forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    button.addEventListener("click", () => sort(table, head, column));
    head.append(button);
  });
  const download = document.createElement("button");
  download.type = "button";
  download.textContent = "CSV";
  download.setAttribute("aria-label", `Download as CSV: ${table.caption.textContent}`);
  download.addEventListener("click", () => save(`${table.id.replace(/^table-/, "")}.csv`, csv(table)));
  table.caption.append(download);
}

function sort(table, head, column) {
  const order = head.getAttribute("aria-sort") === "ascending" ? "descending" : "ascending";
  for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", order);
  const sign = order === "ascending" ? 1 : -1;
  const rows = [...table.tBodies[0].rows].map((row) => ({ row, text: content(row.cells[column]) }));
  rows.sort((a, b) => last(a.text) - last(b.text) || sign * compare(a.text, b.text));
  table.tBodies[0].append(...rows.map(({ row }) => row));
}

/** A number as it was computed, where the cell shows a few of its digits. */
function content(cell) {
  return cell.dataset.whole ?? cell.textContent.trim();
}

/** Cells without a value come last in both orders. */
function last(text) {
  return text === "" || text === "-" ? 1 : 0;
}

/** Numbers by their size, also with a unit behind; all else as words, in which numbers count too. */
function compare(a, b) {
  const [x, y] = [a, b].map((text) => (/^[+-]?[\d.]/.test(text) ? parseFloat(text) : NaN));
  return Number.isNaN(x) || Number.isNaN(y) ? a.localeCompare(b, "en", { numeric: true }) : x - y;
}

function csv(table) {
  const rows = [table.tHead.rows[0], ...table.tBodies[0].rows];
  return rows.map((row) => [...row.cells].map((cell) => quoted(content(cell))).join(",") + "\r\n").join("");
}

function quoted(text) {
  return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

function save(name, text) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}
