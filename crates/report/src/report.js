"use strict";

// Tables: click a heading to sort, type to filter.
for (const holder of document.querySelectorAll(".table")) {
  const table = holder.querySelector("table");
  const rows = [...table.tBodies[0].rows];
  if (rows.length > 6) {
    const search = document.createElement("input");
    search.type = "search";
    search.placeholder = "filter rows";
    search.setAttribute("aria-label", "filter the rows of the table below");
    search.addEventListener("input", () => {
      const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
      for (const row of rows) {
        const text = row.textContent.toLowerCase();
        row.hidden = !words.every((word) => text.includes(word));
      }
    });
    holder.before(search);
  }
  [...table.tHead.rows[0].cells].forEach((cell, column) => {
    const button = document.createElement("button");
    button.textContent = cell.textContent;
    let direction = 1;
    button.addEventListener("click", () => {
      const key = (row) => row.cells[column].textContent.trim();
      const number = (text) => parseFloat(text.replace(/[^0-9eE.+-]/g, ""));
      rows.sort((a, b) => {
        const [x, y] = [number(key(a)), number(key(b))];
        const order = Number.isNaN(x) || Number.isNaN(y) ? key(a).localeCompare(key(b)) : x - y;
        return direction * order;
      });
      rows.forEach((row) => table.tBodies[0].append(row));
      cell.setAttribute("aria-sort", direction > 0 ? "ascending" : "descending");
      direction = -direction;
    });
    cell.replaceChildren(button);
  });
}

// Pictures: click or Enter for their own size.
for (const figure of document.querySelectorAll(".figure")) {
  const image = figure.querySelector("img");
  if (!image) continue;
  const toggle = () => image.classList.toggle("large");
  image.addEventListener("click", toggle);
  figure.addEventListener("keydown", (event) => { if (event.key === "Enter") toggle(); });
}

// Percentage-closer filtering on the left of a slider, a technique on the right, with zoom; drag to move.
for (const comparer of document.querySelectorAll(".comparer")) {
  const image = comparer.previousElementSibling.querySelector("img");
  const [width, height] = [Number(comparer.dataset.width), Number(comparer.dataset.height)];
  const names = JSON.parse(comparer.dataset.names);
  const GAP = 6;
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  canvas.setAttribute("role", "img");
  const control = (text, node) => {
    const label = document.createElement("label");
    label.append(text, " ", node);
    comparer.append(label);
    return node;
  };
  const range = (low, high, value, step) => {
    const node = document.createElement("input");
    Object.assign(node, { type: "range", min: low, max: high, step, value });
    return node;
  };
  const choice = control("technique", document.createElement("select"));
  names.forEach((name, i) => choice.append(new Option(name, i + 1)));
  const slider = control("PCF | technique", range(0, 100, 50, 1));
  const zoom = control("zoom", range(1, 8, 1, 0.5));
  comparer.append(canvas);
  const middle = { x: width / 2, y: height / 2 };
  const draw = () => {
    const context = canvas.getContext("2d");
    const scale = Number(zoom.value);
    const [w, h] = [width / scale, height / scale];
    middle.x = Math.min(Math.max(middle.x, w / 2), width - w / 2);
    middle.y = Math.min(Math.max(middle.y, h / 2), height - h / 2);
    const [left, top] = [middle.x - w / 2, middle.y - h / 2];
    const seam = Math.round(width * Number(slider.value) / 100);
    const column = (index, from, to) => {
      if (to <= from) return;
      const source = index * (width + GAP) + left + from / scale;
      context.drawImage(image, source, top, (to - from) / scale, h, from, 0, to - from, height);
    };
    context.imageSmoothingEnabled = false;
    column(0, 0, seam);
    column(Number(choice.value), seam, width);
    context.fillStyle = "#ffffff";
    context.fillRect(seam - 1, 0, 2, height);
    canvas.setAttribute("aria-label", `PCF left, ${names[choice.value - 1]} right of ${slider.value} %, zoom ${zoom.value}`);
  };
  for (const node of [choice, slider, zoom]) node.addEventListener("input", draw);
  canvas.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    const share = width / canvas.clientWidth / Number(zoom.value);
    middle.x -= event.movementX * share;
    middle.y -= event.movementY * share;
    draw();
  });
  if (image.complete) draw(); else image.addEventListener("load", draw);
}

// Error against cost, with filters.
const COLOURS = [["VSM", "#e69f00"], ["ESM", "#cc79a7"], ["EVSM", "#d55e00"], ["LVSM", "#966e46"], ["CSM", "#009e73"],
  ["Hamburger", "#0072b2"], ["Hausdorff", "#56b4e9"], ["Trigonometric", "#888888"]];
const family = (name) => (COLOURS.find(([prefix]) => name.startsWith(prefix)) || ["PCF", "#6e6e6e"]);

for (const explorer of document.querySelectorAll(".explorer")) {
  const points = JSON.parse(explorer.dataset.points);
  const svgNode = (name, attributes, text) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    if (text !== undefined) node.textContent = text;
    return node;
  };
  const unique = (of) => [...new Set(points.map(of))];
  const boxes = (title, values, label) => {
    const set = document.createElement("fieldset");
    const legend = document.createElement("legend");
    legend.textContent = title;
    set.append(legend);
    const chosen = new Set(values);
    for (const value of values) {
      const line = document.createElement("label");
      const box = document.createElement("input");
      box.type = "checkbox";
      box.checked = true;
      box.addEventListener("change", () => {
        if (box.checked) chosen.add(value); else chosen.delete(value);
        draw();
      });
      line.append(box, " ", label(value));
      set.append(line);
    }
    explorer.append(set);
    return chosen;
  };
  const families = boxes("technique", unique((p) => family(p.technique)[0]), (value) => value);
  const bits = boxes("bits a texel", unique((p) => p.bits).sort((a, b) => a - b), (value) => value);
  const sizes = boxes("map", unique((p) => p.size).sort((a, b) => b - a), (value) => `${value}²`);
  const output = document.createElement("output");
  const svg = svgNode("svg", { viewBox: "0 0 800 420", role: "group", "aria-label": "error against modelled cost" });
  explorer.append(svg, output);
  const describe = (p) =>
    `${p.technique}, ${p.format}, ${p.size}² map: error ${(100 * p.error).toFixed(2)} %, cost ${p.cost.toFixed(3)}, ${p.bits} bits a texel`;

  function draw() {
    svg.replaceChildren();
    const shown = points.filter((p) => families.has(family(p.technique)[0]) && bits.has(p.bits) && sizes.has(p.size));
    const costs = points.map((p) => Math.log(p.cost));
    const [low, high] = [Math.min(...costs), Math.max(...costs)];
    const top = Math.max(...points.map((p) => p.error));
    const x = (p) => 60 + 710 * (Math.log(p.cost) - low) / Math.max(high - low, 1e-9);
    const y = (error) => 370 - 340 * error / top;
    for (let i = 0; i <= 4; i++) {
      const error = top * i / 4;
      svg.append(svgNode("line", { x1: 55, x2: 780, y1: y(error), y2: y(error), stroke: "currentColor", "stroke-opacity": 0.15 }));
      svg.append(svgNode("text", { x: 50, y: y(error) + 4, "text-anchor": "end", "font-size": 12, fill: "currentColor" }, `${(100 * error).toFixed(0)} %`));
    }
    for (const cost of [0.1, 0.2, 0.5, 1, 2, 5, 10]) {
      if (Math.log(cost) < low || Math.log(cost) > high) continue;
      svg.append(svgNode("text", { x: x({ cost }), y: 390, "text-anchor": "middle", "font-size": 12, fill: "currentColor" }, cost));
    }
    svg.append(svgNode("text", { x: 420, y: 412, "text-anchor": "middle", "font-size": 12, fill: "currentColor" },
      "modelled cost of a frame (lower and further left is better)"));
    const competing = shown.filter((p) => p.format !== "depth").sort((a, b) => a.cost - b.cost);
    let best = Infinity;
    const steps = [];
    for (const p of competing) {
      if (p.error >= best) continue;
      if (steps.length) steps.push([x(p), y(best)]);
      best = p.error;
      steps.push([x(p), y(best)]);
    }
    svg.append(svgNode("polyline", { points: steps.join(" "), fill: "none", stroke: "currentColor", "stroke-opacity": 0.6 }));
    for (const p of shown) {
      const mark = svgNode("circle", { cx: x(p), cy: y(p.error), r: 6, fill: family(p.technique)[1], tabindex: 0, role: "img", "aria-label": describe(p) });
      mark.append(svgNode("title", {}, describe(p)));
      const show = () => { output.textContent = describe(p); };
      mark.addEventListener("mouseenter", show);
      mark.addEventListener("focus", show);
      svg.append(mark);
    }
    output.textContent = `${shown.length} of ${points.length} shown; point at one for its numbers`;
  }
  draw();
}
