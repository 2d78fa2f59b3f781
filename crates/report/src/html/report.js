// Pictures: click or Enter for their own size.
for (const figure of document.querySelectorAll(".figure")) {
  const image = figure.querySelector("img");
  if (!image) continue;
  const toggle = () => image.classList.toggle("large");
  image.addEventListener("click", toggle);
  figure.addEventListener("keydown", (event) => { if (event.key === "Enter") toggle(); });
}

// Percentage-closer filtering on the left of a slider, a technique or its difference on the right, with zoom; drag to move.
for (const comparer of document.querySelectorAll(".comparer")) {
  const [width, height] = [Number(comparer.dataset.width), Number(comparer.dataset.height)];
  const names = JSON.parse(comparer.dataset.names);
  const pictures = JSON.parse(comparer.dataset.pictures);
  const gap = Number(comparer.dataset.gap);
  let image = pictures.length ? new Image() : comparer.previousElementSibling.querySelector("img");
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
  const options = (values) => {
    const node = document.createElement("select");
    values.forEach((name, i) => node.append(new Option(name, i)));
    return node;
  };
  const view = pictures.length ? control("view", options(pictures.map((picture) => picture.name))) : null;
  const choice = control("technique", options(names));
  const right = control("right side", options(["picture", "difference from PCF, times 4"]));
  const slider = control("PCF | technique", range(0, 100, 50, 1));
  const zoom = control("zoom", range(1, 8, 1, 0.5));
  comparer.append(canvas);
  const legend = document.createElement("p");
  legend.textContent = "Difference: grey where both agree, white where the technique is brighter than PCF, black where it is darker, by a quarter of the range and more.";
  comparer.append(legend);
  const middle = { x: width / 2, y: height / 2 };
  const draw = () => {
    if (!image.complete || !image.naturalWidth) return;
    const context = canvas.getContext("2d", { willReadFrequently: true });
    const scale = Number(zoom.value);
    const [w, h] = [width / scale, height / scale];
    middle.x = Math.min(Math.max(middle.x, w / 2), width - w / 2);
    middle.y = Math.min(Math.max(middle.y, h / 2), height - h / 2);
    const [left, top] = [middle.x - w / 2, middle.y - h / 2];
    const seam = Math.round(width * Number(slider.value) / 100);
    const column = (index, from, to) => {
      if (to <= from) return;
      const source = index * (width + gap) + left + from / scale;
      context.drawImage(image, source, top, (to - from) / scale, h, from, 0, to - from, height);
    };
    context.imageSmoothingEnabled = false;
    const technique = Number(choice.value) + 1;
    if (right.value === "1" && seam < width) {
      column(0, seam, width);
      const reference = context.getImageData(seam, 0, width - seam, height);
      column(technique, seam, width);
      const shown = context.getImageData(seam, 0, width - seam, height);
      // Grey is no difference, white too bright, black too dark.
      for (let i = 0; i < shown.data.length; i += 4) {
        const change = shown.data[i] + shown.data[i + 1] + shown.data[i + 2]
          - reference.data[i] - reference.data[i + 1] - reference.data[i + 2];
        shown.data[i] = shown.data[i + 1] = shown.data[i + 2] = 128 + 4 * change / 3;
      }
      context.putImageData(shown, seam, 0);
    } else {
      column(technique, seam, width);
    }
    column(0, 0, seam);
    context.fillStyle = "#ffffff";
    context.fillRect(seam - 1, 0, 2, height);
    const where = view ? `${pictures[view.value].name}: ` : "";
    const what = right.value === "1" ? ", difference times 4" : "";
    canvas.setAttribute("aria-label", `${where}PCF left, ${names[choice.value]}${what} right of ${slider.value} %, zoom ${zoom.value}`);
  };
  const load = () => {
    if (view) image.src = pictures[view.value].source;
    if (image.complete) draw();
  };
  image.addEventListener("load", draw);
  if (view) view.addEventListener("input", load);
  for (const node of [choice, right, slider, zoom]) node.addEventListener("input", draw);
  // The divider follows the pointer; with a button held, an enlarged picture moves.
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons && Number(zoom.value) > 1) {
      const share = width / canvas.clientWidth / Number(zoom.value);
      middle.x -= event.movementX * share;
      middle.y -= event.movementY * share;
    } else {
      const box = canvas.getBoundingClientRect();
      slider.value = 100 * (event.clientX - box.left) / box.width;
    }
    draw();
  });
  load();
}

// Values of figures under the pointer.
{
  const tip = document.createElement("div");
  tip.className = "tip";
  tip.setAttribute("role", "status");
  tip.hidden = true;
  document.body.append(tip);
  const cell = (node, event) => {
    const box = node.getBoundingClientRect();
    const cells = node.dataset.cells;
    const count = Math.round(Math.sqrt(cells.length));
    const place = (share) => Math.min(count - 1, Math.max(0, Math.floor(count * share)));
    const column = place((event.clientX - box.left) / box.width);
    const row = place((event.clientY - box.top) / box.height);
    const letter = cells[row * count + column];
    const knob = (text, index) => {
      const [name, from, to] = JSON.parse(text);
      const share = (index + 0.5) / count;
      const value = from > 0 && to > 0 ? from * (to / from) ** share : from + share * (to - from);
      return `${name} ${value.toExponential(1)}`;
    };
    return `${node.dataset.title}, ${knob(node.dataset.x, column)}, ${knob(node.dataset.y, count - 1 - row)}: ${CELLS[letter]}`;
  };
  document.addEventListener("pointermove", (event) => {
    const node = event.target.closest ? event.target.closest(".spot, .grid") : null;
    tip.hidden = !node;
    if (!node) return;
    tip.textContent = node.matches(".grid") ? cell(node, event) : node.querySelector("title").textContent;
    tip.style.left = `${Math.max(4, Math.min(event.clientX + 14, window.innerWidth - tip.offsetWidth - 4))}px`;
    tip.style.top = `${event.clientY + 18 + tip.offsetHeight > window.innerHeight ? event.clientY - tip.offsetHeight - 10 : event.clientY + 18}px`;
  });
}

const svgNode = (name, attributes, text) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== undefined) node.textContent = text;
  return node;
};

// Every candidate of the search, found by its functions.
for (const holder of document.querySelectorAll(".candidates")) {
  const { functions, sizes } = JSON.parse(holder.dataset.candidates);
  const decoded = new Map(sizes.map(({ m, data }) => {
    const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    const count = bytes.length / (m + 4);
    return [m, {
      count,
      members: (i) => [...bytes.subarray(i * (m + 4), i * (m + 4) + m)],
      error: (i) => view.getUint32(i * (m + 4) + m, true) * CANDIDATES.unit,
    }];
  }));
  // One spelling of a function: exp(1 z), e^(z) and EXP( z ) are exp(z).
  const plain = (text) => text.toLowerCase().replace(/\s+/g, "").replace(/\*\*/g, "^").replace(/[*·]/g, "").replace(/π/g, "pi")
    .replace(/²/g, "^2").replace(/³/g, "^3").replace(/\blog\(/g, "ln(").replace(/e\^\(/g, "exp(").replace(/e\^(-?[0-9.]*z)/g, "exp($1)")
    .replace(/\(([+]?)1(?=pi|z)/g, "(").replace(/\(-1(?=pi|z)/g, "(-").replace(/z\^1(?![0-9])/g, "z");
  // power:M and trig:N stand for several.
  const meant = (word) => {
    const [, kind, count] = word.match(/^(power|trig):([0-9]+)$/) ?? [];
    const numbers = [...Array(Math.min(Number(count ?? 0), 16)).keys()].map((k) => k + 1);
    if (kind === "power") return numbers.map((k) => plain(`z^${k}`));
    if (kind === "trig") return numbers.flatMap((k) => [plain(`sin(${2 * k}pi z)`), plain(`cos(${2 * k}pi z)`)]);
    return [word];
  };
  const labelled = (text, node) => {
    const label = document.createElement("label");
    label.append(text, " ", node);
    holder.append(label);
    return node;
  };
  const size = document.createElement("select");
  for (const m of decoded.keys()) size.append(new Option(`${m} functions`, m));
  size.value = decoded.has(4) ? 4 : [...decoded.keys()].pop();
  labelled("candidates of", size);
  const search = document.createElement("input");
  search.type = "search";
  search.placeholder = CANDIDATES.example;
  search.size = 40;
  labelled("with the functions", search);
  const output = document.createElement("output");
  const svg = svgNode("svg", { viewBox: "0 0 800 260", role: "img", "aria-label": "candidates by error" });
  const list = document.createElement("ol");
  holder.append(output, svg, list);
  const known = document.createElement("p");
  known.className = "known";
  known.append("Functions: ");
  functions.forEach((name, i) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = name;
    button.addEventListener("click", () => {
      const now = search.value.trim().replace(/,$/, "");
      search.value = now ? `${now}, ${name}` : name;
      draw();
    });
    known.append(i ? " " : "", button);
  });
  holder.append(known);
  const percent = (error) => `${(100 * error).toFixed(3)} %`;
  function draw() {
    const m = Number(size.value);
    const all = decoded.get(m);
    const words = search.value.split(",").map(plain).filter(Boolean).flatMap(meant);
    const wanted = words.map((word) => functions.findIndex((name) => plain(name) === word));
    const unknown = words.filter((_, i) => wanted[i] < 0);
    const found = [];
    for (let i = 0; words.length && !unknown.length && i < all.count; i++) {
      const members = all.members(i);
      if (wanted.every((function_) => members.includes(function_))) found.push(i);
    }
    const end = Math.min(2.5 * all.error(0), 1.02 * all.error(all.count - 1));
    const BINS = 120;
    const bin = (i) => Math.floor(BINS * all.error(i) / end);
    const counts = new Array(BINS).fill(0);
    const chosen = new Array(BINS).fill(0);
    for (let i = 0; i < all.count; i++) if (bin(i) < BINS) counts[bin(i)]++;
    for (const i of found) if (bin(i) < BINS) chosen[bin(i)]++;
    const most = Math.max(...counts, 1);
    const x = (error) => 60 + 720 * error / end;
    svg.replaceChildren();
    counts.forEach((count, k) => {
      if (!count) return;
      const bar = (number, colour) => svgNode("rect", { x: x(end * k / BINS), width: 720 / BINS - 1, y: 210 - 190 * number / most,
        height: 190 * number / most, fill: colour });
      svg.append(bar(count, CANDIDATES.all));
      if (chosen[k]) svg.append(bar(Math.max(chosen[k], 0.01 * most), CANDIDATES.chosen));
      const spot = svgNode("rect", { class: "spot", x: x(end * k / BINS), width: 720 / BINS, y: 10, height: 200, "fill-opacity": 0 });
      spot.append(svgNode("title", {}, `${percent(end * k / BINS)} to ${percent(end * (k + 1) / BINS)}: ${count} candidates${words.length ? `, ${chosen[k]} of them with these functions` : ""}`));
      svg.append(spot);
    });
    for (let k = 0; k <= 5; k++) {
      svg.append(svgNode("text", { x: x(end * k / 5), y: 228, "text-anchor": "middle", "font-size": 12, fill: "currentColor" }, `${(100 * end * k / 5).toFixed(1)} %`));
    }
    svg.append(svgNode("text", { x: 420, y: 250, "text-anchor": "middle", "font-size": 12, fill: "currentColor" },
      "mean |G - F| (further left is better)"));
    const exact = found.length === 1 && words.length === m ? found[0] : -1;
    if (exact >= 0) svg.append(svgNode("line", { x1: x(all.error(exact)), x2: x(all.error(exact)), y1: 4, y2: 212, stroke: CANDIDATES.chosen, "stroke-width": 2 }));
    const name = (i) => all.members(i).map((index) => functions[index]).join(", ");
    const shown = (words.length ? found : [...Array(Math.min(all.count, 5)).keys()]).slice(0, 8);
    list.replaceChildren(...shown.map((i) => {
      const item = document.createElement("li");
      item.value = i + 1;
      item.textContent = `${name(i)}: ${percent(all.error(i))}`;
      return item;
    }));
    output.textContent = unknown.length ? `not in the family: ${unknown.join(", ")}`
      : exact >= 0 ? `rank ${exact + 1} of ${all.count}: ${percent(all.error(exact))}`
      : words.length ? `${found.length} of ${all.count} candidates have these functions${found.length ? `, the best with rank ${found[0] + 1}` : ""}`
      : `${all.count} candidates; the best ones below, numbered by rank`;
  }
  size.addEventListener("input", draw);
  search.addEventListener("input", draw);
  draw();
}

// Error against cost, with filters.
for (const explorer of document.querySelectorAll(".explorer")) {
  const points = JSON.parse(explorer.dataset.explorer);
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
      line.append(box, " ");
      if (FAMILIES[value]) {
        const swatch = document.createElement("span");
        swatch.className = "swatch";
        swatch.style.background = FAMILIES[value];
        line.append(swatch);
      }
      line.append(label(value));
      set.append(line);
    }
    explorer.append(set);
    return chosen;
  };
  const families = boxes("technique", unique((p) => p.family), (value) => value);
  const bits = boxes("bits a texel", unique((p) => p.bits).sort((a, b) => a - b), (value) => value);
  const sizes = boxes("map", unique((p) => p.size).sort((a, b) => b - a), (value) => `${value}²`);
  const output = document.createElement("output");
  const svg = svgNode("svg", { viewBox: "0 0 800 420", role: "group", "aria-label": "error against modelled cost" });
  const plot = document.createElement("div");
  plot.className = "plot";
  plot.append(svg);
  explorer.append(plot, output);
  const describe = (p) =>
    `${p.technique}, ${p.format}, ${p.size}² map: error ${(100 * p.error).toFixed(2)} %${p.relative === null ? "" : ` (${p.relative.toFixed(3)} of no shadows at all)`}, cost ${p.cost.toFixed(3)}, ${p.bits} bits a texel`;

  function draw() {
    svg.replaceChildren();
    const shown = points.filter((p) => families.has(p.family) && bits.has(p.bits) && sizes.has(p.size));
    const costs = points.map((p) => Math.log(p.cost));
    const [low, high] = [Math.min(...costs), Math.max(...costs)];
    const top = Math.max(...points.map((p) => p.error));
    const x = (p) => 60 + 710 * (Math.log(p.cost) - low) / Math.max(high - low, 1e-9);
    const y = (error) => 370 - 340 * error / top;
    const rough = top / 5;
    const unit = 10 ** Math.floor(Math.log10(rough));
    const step = unit * [1, 2, 5, 10].find((factor) => factor * unit >= rough);
    const digits = Math.max(0, -Math.floor(Math.log10(100 * step)));
    svg.append(svgNode("text", { x: 55, y: 14, "font-size": 12, fill: "currentColor" }, "mean |G - F|, in percent"));
    for (let error = 0; error <= top * (1 + 1e-9); error += step) {
      svg.append(svgNode("line", { x1: 55, x2: 780, y1: y(error), y2: y(error), stroke: "currentColor", "stroke-opacity": 0.15 }));
      svg.append(svgNode("text", { x: 50, y: y(error) + 4, "text-anchor": "end", "font-size": 12, fill: "currentColor" }, `${(100 * error).toFixed(digits)} %`));
    }
    for (const cost of [0.1, 0.2, 0.5, 1, 2, 5, 10]) {
      if (Math.log(cost) < low || Math.log(cost) > high) continue;
      svg.append(svgNode("text", { x: x({ cost }), y: 390, "text-anchor": "middle", "font-size": 12, fill: "currentColor" }, cost));
    }
    svg.append(svgNode("text", { x: 420, y: 412, "text-anchor": "middle", "font-size": 12, fill: "currentColor" },
      "modelled cost of a frame (lower and further left is better)"));
    const competing = shown.filter((p) => p.competes).sort((a, b) => a.cost - b.cost);
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
      const mark = svgNode("circle", { cx: x(p), cy: y(p.error), r: 6, fill: FAMILIES[p.family], tabindex: -1, role: "img", "aria-label": describe(p) });
      mark.append(svgNode("title", {}, describe(p)));
      const show = () => { output.textContent = describe(p); };
      mark.addEventListener("mouseenter", show);
      mark.addEventListener("focus", show);
      svg.append(mark);
    }
    // One stop for the tabulator, arrow keys from mark to mark in the order of cost.
    const marks = [...svg.querySelectorAll("circle")].sort((a, b) => a.cx.baseVal.value - b.cx.baseVal.value);
    if (marks.length) marks[0].setAttribute("tabindex", 0);
    svg.onkeydown = (event) => {
      const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
      const at = marks.indexOf(document.activeElement);
      const next = way && at >= 0 ? marks[at + way] : null;
      if (!next) return;
      event.preventDefault();
      marks[at].setAttribute("tabindex", -1);
      next.setAttribute("tabindex", 0);
      next.focus();
    };
    output.textContent = `${shown.length} of ${points.length} shown; point at one for its numbers, or go from one to the next with the arrow keys. The line joins the techniques that nothing cheaper beats; PCF stands beside them for comparison: it is the truth at full size, and no map that can be filtered.`;
  }
  draw();
}
