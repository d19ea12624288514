"use strict";
(() => {
  const raw = (cell) => (cell.dataset.v === undefined ? null : Number(cell.dataset.v || cell.textContent));
  const order = (a, b, sign) => {
    const x = raw(a), y = raw(b), s = a.textContent, t = b.textContent;
    // empty cells stay at the end whichever way the rest is sorted
    if (s === "–" || t === "–") return (s === "–") - (t === "–");
    if (x !== null && y !== null) return sign * (x - y);
    return sign * s.localeCompare(t, "en", { numeric: true });
  };
  const sort = (head) => {
    const table = head.closest("table"), body = table.tBodies[0], column = head.cellIndex;
    const up = head.getAttribute("aria-sort") !== "ascending";
    for (const other of table.tHead.rows[0].cells) other.setAttribute("aria-sort", "none");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const rows = Array.from(body.rows);
    rows.sort((a, b) => order(a.cells[column], b.cells[column], up ? 1 : -1));
    body.append(...rows);
  };
  const field = (cell) => {
    const value = cell.dataset.v;
    let text = value === undefined ? cell.textContent : value || cell.textContent;
    if (text === "–") text = "";
    // a spreadsheet would run text that begins like this as a formula
    if (value === undefined && /^\s*[=+\-@\t\r]/.test(text)) text = "'" + text;
    return /[",\n\r]/.test(text) ? '"' + text.replaceAll('"', '""') + '"' : text;
  };
  const title = (cell) => {
    const copy = cell.cloneNode(true);
    return field({ dataset: {}, textContent: copy.textContent.trim() });
  };
  const csv = (table) =>
    [Array.from(table.tHead.rows[0].cells, title), ...Array.from(table.tBodies[0].rows, (r) => Array.from(r.cells, field))]
      .map((row) => row.join(",")).join("\n") + "\n";
  const copy = async (text) => {
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      const area = document.createElement("textarea");
      area.value = text;
      document.body.append(area);
      area.select();
      const done = document.execCommand("copy");
      area.remove();
      if (!done) throw new Error("the browser refused the clipboard");
    }
  };
  document.addEventListener("click", async (event) => {
    const button = event.target.closest("button");
    if (!button) return;
    if (button.classList.contains("sort")) return sort(button.closest("th"));
    const box = button.closest(".table"), said = box.querySelector(".said"), table = box.querySelector("table");
    try {
      await copy(csv(table));
      said.textContent = `Copied ${table.tBodies[0].rows.length} rows.`;
    } catch (error) {
      said.textContent = `Not copied: ${error.message}.`;
    }
  });
  window.sstlCsv = csv;
})();
