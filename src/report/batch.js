// Filters the cells of a batch, and draws the maps of two chosen factors over the cells that are shown.
"use strict";
(() => {
  const data = JSON.parse(document.getElementById("batch-data").textContent);
  const table = document.getElementById("batch-cells");
  const maps = document.getElementById("batch-maps");
  const rows = [...table.tBodies[0].rows];
  const make = (name, text, of) => {
    const element = document.createElement(name);
    if (text !== undefined) element.textContent = text;
    if (of) of.append(element);
    return element;
  };
  const choice = (place, title, options, change) => {
    const label = make("label", `${title} `, place);
    const select = make("select", undefined, label);
    options.forEach(([value, text]) => { make("option", text, select).value = value; });
    select.onchange = change;
    return select;
  };

  // Filters: a level of each factor that varies, and the state.
  const filters = document.getElementById("batch-filters");
  const byFactor = data.factors.map((f) =>
    choice(filters, f.name, [["", "all"], ...f.levels.map((l, i) => [String(i), l])], () => show()));
  const states = [...new Set(data.cells.map((c) => c.state))];
  const byState = choice(filters, "state", [["", "all"], ...states.map((s) => [s, s.replaceAll("_", " ")])], () => show());
  const isShown = (cell) =>
    (byState.value === "" || cell.state === byState.value) &&
    data.factors.every((f, i) => byFactor[i].value === "" || cell.levels[f.index] === Number(byFactor[i].value));

  // Maps: two factors and a measure.
  const controls = document.getElementById("batch-map-controls");
  const factors = data.factors.filter((f) => !f.is_scenario);
  const names = factors.map((f) => [String(f.index), f.name]);
  const down = maps && choice(controls, "rows", names, () => draw());
  const across = maps && choice(controls, "columns", [["", "none"], ...names], () => draw());
  const measure = maps && choice(controls, "shown", data.measures.map((m, i) => [String(i), m[0]]), () => draw());
  if (maps) {
    if (data.shown.length > 0) down.value = String(data.shown[0]);
    across.value = data.shown.length > 1 ? String(data.shown[1]) : "";
  }

  const percent = (share) => `${share === 0 ? "0" : (100 * share).toFixed(share < 0.0995 ? 1 : 0)} %`;
  const mix = (strength) => {
    const part = (i) => parseInt(data.full.slice(1 + 2 * i, 3 + 2 * i), 16);
    return `rgb(${[0, 1, 2].map((i) => Math.round(255 + (part(i) - 255) * strength)).join(",")})`;
  };
  const field = (row, cells) => {
    const [, isShare, low, high] = data.measures[Number(measure.value)];
    const values = cells.map((c) => c.values[Number(measure.value)]).filter((v) => v !== null);
    const td = make("td", undefined, row);
    td.className = "n";
    if (values.length === 0) {
      td.textContent = cells.length === 0 ? "\u2013" : "no path";
      return;
    }
    const mean = values.reduce((a, b) => a + b, 0) / values.length;
    td.textContent = isShare ? percent(mean) : mean.toFixed(2);
    td.style.background = mix(Math.min(Math.max((mean - low) / (high - low), 0), 1));
    if (cells.length > 1) {
      const rest = cells.length - values.length;
      make("span", `of ${values.length} cells${rest ? `, ${rest} without a path` : ""}`, td).className = "small";
    }
  };
  const draw = () => {
    if (!maps || factors.length === 0) return;
    maps.replaceChildren();
    const factor = (select) => factors.find((f) => String(f.index) === select.value);
    const [d, a] = [factor(down), factor(across)];
    const shown = data.cells.filter(isShown);
    data.stations.forEach((name, station) => {
      const own = shown.filter((c) => c.station === station);
      if (own.length === 0) return;
      make("h3", name, maps);
      const scroll = make("div", undefined, maps);
      scroll.className = "scroll";
      const map = make("table", undefined, scroll);
      map.className = "map";
      const used = (f) => f.levels.map((l, i) => i).filter((i) => own.some((c) => c.levels[f.index] === i));
      const columns = a && a !== d ? used(a) : [null];
      const head = make("tr", undefined, make("thead", undefined, map));
      make("th", a && a !== d ? `${d.name} \u2193, ${a.name} \u2192` : d.name, head);
      columns.forEach((c) => { make("th", c === null ? "all cells" : a.levels[c], head).className = "n"; });
      const body = make("tbody", undefined, map);
      used(d).forEach((r) => {
        const row = make("tr", undefined, body);
        make("th", d.levels[r], row).scope = "row";
        columns.forEach((c) => field(row, own.filter((cell) =>
          cell.levels[d.index] === r && (c === null || cell.levels[a.index] === c))));
      });
    });
  };
  const show = () => {
    let count = 0;
    rows.forEach((row) => {
      const is = isShown(data.cells[Number(row.dataset.cell)]);
      row.hidden = !is;
      count += is ? 1 : 0;
    });
    document.getElementById("batch-count").textContent = `${count} of ${rows.length} cells`;
    draw();
  };
  show();
})();
