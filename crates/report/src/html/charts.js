// Charts: uPlot draws axes, lines and bars; marks of several shapes, keys and what is said about a point are added here.
const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const redrawn = [];
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => redrawn.forEach((draw) => draw()));
const FONT = "12px system-ui, sans-serif";
// Ticks in percent with the digits that their distance needs.
const percents = (u, all, axis, space, step) => {
  const digits = [0, 1, 2, 3].find((digits) => Math.abs(100 * step * 10 ** digits - Math.round(100 * step * 10 ** digits)) < 1e-6) ?? 4;
  return all.map((value) => `${(100 * value).toFixed(digits)} %`);
};

// One stop for the tabulator; arrow keys go through `points()`, each { x, y, text }, and the nearest is told under the pointer.
// `chosen` is what `after`, which draws on the canvas, has to stress.
const chart = ({ holder, label, height, scales, axes, series, data, points, after, say }) => {
  let plot = null;
  let chosen = null;
  holder.tabIndex = 0;
  holder.setAttribute("role", "application");
  holder.setAttribute("aria-roledescription", "chart");
  holder.setAttribute("aria-label", `${label}; arrow keys go from one to the next`);
  const choose = (point) => {
    chosen = point;
    if (point) say(point.text);
    plot.redraw(false);
  };
  const build = () => {
    plot?.destroy();
    const [ink, line] = [style("--fore"), style("--line")];
    const axis = (of) => ({
      stroke: ink, font: FONT, labelFont: FONT, labelSize: 18, labelGap: 0,
      grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1, size: 5 }, ...of,
    });
    plot = new uPlot({
      width: holder.clientWidth || 320, height, scales, axes: axes.map(axis), series: series(), legend: { show: false },
      cursor: { show: false }, padding: [8, 18, 0, 0],
      hooks: { draw: [(u) => { u.ctx.save(); after(u, chosen); u.ctx.restore(); }] },
    }, data(), holder);
    plot.over.addEventListener("pointermove", (event) => {
      const box = plot.over.getBoundingClientRect();
      let [near, least] = [null, 24];
      for (const point of points()) {
        const distance = Math.hypot(plot.valToPos(point.x, "x") - event.clientX + box.left, plot.valToPos(point.y, "y") - event.clientY + box.top);
        if (distance < least) [near, least] = [point, distance];
      }
      if (near !== chosen) choose(near);
    });
    plot.over.addEventListener("pointerleave", () => choose(null));
  };
  holder.addEventListener("keydown", (event) => {
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, Home: -Infinity, End: Infinity }[event.key];
    const all = points();
    if (!way || !all.length) return;
    event.preventDefault();
    const at = all.indexOf(chosen);
    choose(all[at < 0 && Number.isFinite(way) ? 0 : Math.min(all.length - 1, Math.max(0, at + way))]);
  });
  holder.addEventListener("blur", () => choose(null));
  build();
  redrawn.push(build);
  new ResizeObserver(() => { if (holder.clientWidth && holder.clientWidth !== plot.width) plot.setSize({ width: holder.clientWidth, height }); }).observe(holder);
  return () => { chosen = null; plot.setData(data()); };
};

// A disc, a square or a triangle; hatched ones are outlines with strokes through them.
const mark = (u, [x, y], shape, colour, hatched, large) => {
  const { ctx } = u;
  const r = (large ? 8 : hatched ? 6 : 5) * uPlot.pxRatio;
  const path = new Path2D();
  if (shape === 0) path.arc(x, y, r, 0, 2 * Math.PI);
  else if (shape === 1) path.rect(x - r, y - r, 2 * r, 2 * r);
  else { path.moveTo(x, y - r); path.lineTo(x - r, y + r); path.lineTo(x + r, y + r); path.closePath(); }
  ctx.lineWidth = 1.5 * uPlot.pxRatio;
  if (hatched) {
    ctx.strokeStyle = colour;
    ctx.stroke(path);
    ctx.save();
    ctx.clip(path);
    ctx.beginPath();
    for (let k = -2; k <= 2; k++) { ctx.moveTo(x - r + k * r / 1.5, y + r); ctx.lineTo(x + r + k * r / 1.5, y - r); }
    ctx.stroke();
    ctx.restore();
  } else {
    ctx.fillStyle = colour;
    ctx.fill(path);
  }
  if (large) { ctx.strokeStyle = style("--fore"); ctx.lineWidth = 2 * uPlot.pxRatio; ctx.stroke(path); }
};

// Names beside their places, where they cover neither a mark nor another name.
const names = (u, all, marks) => {
  const { ctx } = u;
  const ratio = uPlot.pxRatio;
  ctx.font = `${11 * ratio}px system-ui, sans-serif`;
  ctx.fillStyle = style("--fore");
  ctx.textBaseline = "middle";
  ctx.textAlign = "left";
  const taken = marks.map(([x, y]) => [x - 5 * ratio, y - 5 * ratio, x + 5 * ratio, y + 5 * ratio]);
  const { left, top, width, height } = u.bbox;
  for (const [name, x, y] of all) {
    const w = ctx.measureText(name).width;
    const h = 6.5 * ratio;
    const places = [[8, -10], [8, 10], [8, 0], [8, -20], [8, 20], [8, -34]].flatMap(([dx, dy]) => [[x + dx * ratio, y + dy * ratio], [x - dx * ratio - w, y + dy * ratio]]);
    const free = ([a, b]) => a > left && a + w < left + width && b - h > top && b + h < top + height
      && !taken.some((box) => a < box[2] && a + w > box[0] && b - h < box[3] && b + h > box[1]);
    const place = places.find(free);
    if (!place) continue;
    taken.push([place[0], place[1] - h, place[0] + w, place[1] + h]);
    ctx.fillText(name, ...place);
  }
};

// Error against cost in every application.
for (const holder of document.querySelectorAll(".tradeoffs")) {
  const applications = JSON.parse(holder.dataset.tradeoffs);
  const every = applications.flatMap((of) => of.techniques);
  const filters = document.createElement("details");
  filters.className = "filters";
  // A phone's screen is for the answers.
  filters.open = window.innerWidth > 768;
  filters.append(Object.assign(document.createElement("summary"), { textContent: "Filters" }));
  holder.before(filters);
  const updates = [];
  const boxes = (title, values, word) => {
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
        updates.forEach((update) => update());
      });
      line.append(box, " ", ...word(value));
      set.append(line);
    }
    filters.append(set);
    return chosen;
  };
  const swatch = (family) => {
    const node = document.createElement("span");
    node.className = "swatch";
    node.style.background = `var(${FAMILIES[family]})`;
    return node;
  };
  const unique = (of) => [...new Set(every.map(of))];
  const shownApplications = boxes("application", applications.map((of) => of.application), (name) => [name]);
  const families = boxes("technique", Object.keys(FAMILIES).filter((name) => every.some((p) => p.family === name)), (name) => [swatch(name), name]);
  const bits = boxes("bits a texel", unique((p) => p.bits).sort((a, b) => a - b), (value) => [`${value}`]);
  const output = document.createElement("output");
  holder.after(output);
  const percent = (error, digits) => `${(100 * error).toFixed(digits)} %`;
  holder.replaceChildren();
  for (const { application, cost, error, techniques } of applications) {
    const sizes = [...new Set(techniques.map((p) => p.size ?? 0))].sort((a, b) => b - a);
    const all = techniques.map((p) => ({
      ...p, x: p.cost, y: p.error, shape: Math.min(2, sizes.indexOf(p.size ?? 0)),
      text: `${application}: ${p.name}${p.size ? `, ${p.size}² map` : ""}: error ${percent(p.error, 2)}, ${cost} ${Number(p.cost.toPrecision(3))}, `
        + `${p.bits} bits a texel${p.breaks === undefined ? "" : `, breaks on ${p.breaks === 0 ? "none" : p.breaks.toExponential(1)} of a scene's fragments`}`,
    })).sort((a, b) => a.x - b.x);
    const shown = () => all.filter((p) => families.has(p.family) && bits.has(p.bits));
    const front = () => {
      let best = Infinity;
      return new Set(shown().filter((p) => p.competes).sort((a, b) => a.x - b.x || a.y - b.y).filter((p) => p.y < best && (best = p.y, true)));
    };
    const [low, high] = [0.85 * all[0].x, 1.3 * all[all.length - 1].x];
    const top = 1.06 * Math.max(...all.map((p) => p.y + p.margin));
    const ticks = [];
    for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); e++) {
      const decades = Math.log10(high / low);
      for (const k of decades > 2.5 ? [1] : decades > 0.9 ? [1, 2, 5] : [1, 1.5, 2, 3, 5, 7]) {
        const tick = Number((k * 10 ** e).toPrecision(2));
        if (tick >= low && tick <= high) ticks.push(tick);
      }
    }
    const figure = document.createElement("figure");
    const title = document.createElement("figcaption");
    title.textContent = `${application}: ${error}`;
    const place = document.createElement("div");
    place.className = "chart";
    figure.append(title, place);
    holder.append(figure);
    const redraw = chart({
      holder: place,
      label: `error against ${cost}, ${application}`,
      height: 280,
      scales: { x: { time: false, distr: 3, range: [low, high] }, y: { range: [0, top] } },
      axes: [
        { label: cost.split(";")[0], splits: () => ticks, filter: (u, all) => all, values: (u, all) => all.map((tick) => `${tick}`) },
        { label: "error", size: 52, values: percents },
      ],
      series: () => [{}, { stroke: style("--fore"), width: 1.5, spanGaps: true, points: { show: false }, paths: uPlot.paths.stepped({ align: 1 }) }],
      data: () => {
        const on = front();
        return [all.map((p) => p.x), all.map((p) => on.has(p) ? p.y : null)];
      },
      points: shown,
      say: (text) => { output.textContent = text; },
      after: (u, chosen) => {
        const on = front();
        const at = (p) => [u.valToPos(p.x, "x", true), u.valToPos(p.y, "y", true)];
        for (const p of [...shown().filter((p) => p !== chosen), ...(chosen ? [chosen] : [])]) {
          u.ctx.globalAlpha = p === chosen || on.has(p) || !p.competes ? 1 : 0.4;
          mark(u, at(p), p.shape, style(FAMILIES[p.family]), p.breaks > UNSTABLE, p === chosen);
        }
        u.ctx.globalAlpha = 1;
        names(u, [...on].map((p) => [p.name, ...at(p)]), shown().map(at));
      },
    });
    updates.push(() => { figure.hidden = !shownApplications.has(application); if (!figure.hidden) redraw(); });
  }
  const tell = () => {
    const count = every.filter((p) => families.has(p.family) && bits.has(p.bits)).length;
    output.textContent = `${count} of ${every.length} shown; point at one for its numbers, or go through a chart with the arrow keys.`;
  };
  updates.push(tell);
  tell();
}
