// Lets the reader sort the tables of a page by a click on a heading.
"use strict";
(() => {
  /** What a cell is sorted by: its first line as a number, if it begins with one, or as text. */
  const key = (row, column) => {
    const cell = row.cells[column];
    const text = (cell ? cell.firstChild?.textContent ?? cell.textContent : "").trim();
    const plain = text.replace("\u2212", "-");
    const bound = { "<": -1e-9, ">": 1e-9 }[plain[0]] || 0;
    const number = parseFloat(plain.replace(/^[<>+]/, ""));
    return { text, number: Number.isNaN(number) ? null : number + bound };
  };
  const compare = (a, b) => {
    if (a.number !== null && b.number !== null) return a.number - b.number;
    // Numbers before words, in either direction of numbers.
    if ((a.number === null) !== (b.number === null)) return a.number === null ? 1 : -1;
    return a.text.localeCompare(b.text, "en");
  };
  for (const table of document.querySelectorAll("main table:not(.map)")) {
    const body = table.tBodies[0];
    const headings = table.tHead ? [...table.tHead.rows[0].cells] : [];
    if (!body || body.rows.length < 2 || table.querySelector("[colspan], [rowspan]")) continue;
    headings.forEach((heading, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "sort";
      button.append(...heading.childNodes);
      heading.append(button);
      button.onclick = () => {
        const up = heading.getAttribute("aria-sort") !== "ascending";
        headings.forEach((h) => h.removeAttribute("aria-sort"));
        heading.setAttribute("aria-sort", up ? "ascending" : "descending");
        const rows = [...body.rows].map((row) => ({ row, key: key(row, column) }));
        rows.sort((a, b) => (up ? 1 : -1) * compare(a.key, b.key));
        body.append(...rows.map((r) => r.row));
      };
    });
  }
})();
