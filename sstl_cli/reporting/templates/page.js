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

  // pictures: the values under the pointer; drag a box to see it larger, double click or 0 to see all again
  const value = (scale, share) => {
    const log = scale.log ? Math.log10 : (v) => v, back = scale.log ? (v) => 10 ** v : (v) => v;
    const shown = Number(back(log(scale.from) + share * (log(scale.to) - log(scale.from))).toPrecision(4));
    const [name, unit] = scale.label.split(" / ");
    return `${name} ${shown}${unit && unit !== "1" ? " " + unit : ""}`;
  };
  const place = (svg, event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  for (const svg of document.querySelectorAll("svg[data-axes]")) {
    const axes = JSON.parse(svg.dataset.axes), whole = svg.getAttribute("viewBox").split(/\s+/).map(Number);
    const said = document.createElement("p");
    said.className = "readout";
    said.textContent = "\u00a0";
    svg.after(said);
    const tell = (at) => {
      const found = axes.find(({ box: [l, t, r, b] }) => at.x >= l && at.x <= r && at.y >= t && at.y <= b);
      if (!found) return (said.textContent = "\u00a0");
      const [l, t, r, b] = found.box, parts = [];
      if (found.x) parts.push(value(found.x, (at.x - l) / (r - l)));
      if (found.y) parts.push(value(found.y, (b - at.y) / (b - t)));
      said.textContent = parts.join(", ");
    };
    const view = (x, y, w) => svg.setAttribute("viewBox", [x, y, w, (w * whole[3]) / whole[2]].join(" "));
    const all = () => view(whole[0], whole[1], whole[2]);
    let from = null, frame = null;
    svg.addEventListener("pointermove", (event) => {
      const at = place(svg, event);
      tell(at);
      if (!from) return;
      if (!frame) {
        frame = document.createElementNS("http:".concat("//www.w3.org/2000/svg"), "rect");
        frame.setAttribute("class", "frame");
        svg.append(frame);
      }
      const box = { x: Math.min(at.x, from.x), y: Math.min(at.y, from.y), width: Math.abs(at.x - from.x), height: Math.abs(at.y - from.y) };
      for (const [name, number] of Object.entries(box)) frame.setAttribute(name, number);
    });
    svg.addEventListener("pointerdown", (event) => {
      // a finger scrolls the page
      if (event.pointerType === "touch" || event.button) return;
      from = place(svg, event);
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointerup", (event) => {
      if (from && frame) {
        const to = place(svg, event), w = Math.abs(to.x - from.x), h = Math.abs(to.y - from.y);
        const wide = Math.max(w, (h * whole[2]) / whole[3]);
        if (Math.max(w, h) > 8) view((to.x + from.x - wide) / 2, (to.y + from.y) / 2 - (wide * whole[3]) / whole[2] / 2, wide);
        frame.remove();
      }
      from = frame = null;
    });
    svg.addEventListener("pointerleave", () => (said.textContent = "\u00a0"));
    svg.addEventListener("dblclick", all);
    svg.addEventListener("keydown", (event) => {
      const [x, y, w, h] = svg.getAttribute("viewBox").split(/\s+/).map(Number), step = w / 10;
      const moves = {
        "+": () => view(x + w / 8, y + h / 8, w * 0.75), "-": () => view(x - w / 6, y - h / 6, Math.min(w / 0.75, whole[2])), 0: all,
        ArrowLeft: () => view(x - step, y, w), ArrowRight: () => view(x + step, y, w), ArrowUp: () => view(x, y - step, w), ArrowDown: () => view(x, y + step, w),
      };
      const zoomed = w < whole[2] - 1e-6;
      if (!(event.key in moves) || (event.key.startsWith("Arrow") && !zoomed) || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      moves[event.key]();
      if (svg.viewBox.baseVal.width >= whole[2] - 1e-6) all();
    });
  }
})();
