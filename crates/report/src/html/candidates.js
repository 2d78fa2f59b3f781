// Every candidate of the search, found by its functions.
const candidates = (holder, { functions, marks, sizes }) => {
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const bits = Math.max(1, Math.ceil(Math.log2(functions.length)));
  const decoded = new Map(sizes.map((of) => {
    const places = bytes(of.members);
    const place = (i) => ((places[i * bits >> 3] | places[(i * bits >> 3) + 1] << 8) >> (i * bits & 7)) & ((1 << bits) - 1);
    const numbers = (text) => {
      const all = [];
      let [sum, shift] = [0, 0];
      for (const byte of bytes(text)) {
        sum += (byte & 127) * 2 ** shift;
        shift = byte > 127 ? shift + 7 : 0;
        if (!shift) { all.push(sum); sum = 0; }
      }
      return all;
    };
    let last = 0;
    const errors = numbers(of.errors).map((more) => (last += more) * CANDIDATES.unit);
    const levels = (text) => { let level = 0; return numbers(text).map((n) => level += n % 2 ? -(n + 1) / 2 : n / 2); };
    const [above, below] = [levels(of.above), levels(of.below)];
    return [of.m, {
      count: of.count,
      // Of many only the best are here.
      total: of.count < of.all ? `the best ${of.count} of ${of.all}` : of.count,
      all: of.all,
      members: (i) => Array.from({ length: of.m }, (_, k) => place(i * of.m + k)),
      error: (i) => errors[i],
      ranks: (i) => above[i] + below[i] ? ` (${i + 1 - above[i]} to ${i + 1 + below[i]})` : "",
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
  const plot = document.createElement("div");
  plot.className = "chart";
  const told = document.createElement("p");
  const list = document.createElement("ol");
  holder.append(output, plot, told, list);
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
  const BINS = 120;
  let drawn = null;
  let redraw = null;
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
    const width = end / BINS;
    const bin = (i) => Math.floor(all.error(i) / width);
    const counts = new Array(BINS).fill(0);
    const chosen = new Array(BINS).fill(0);
    for (let i = 0; i < all.count; i++) if (bin(i) < BINS) counts[bin(i)]++;
    for (const i of found) if (bin(i) < BINS) chosen[bin(i)]++;
    const most = Math.max(...counts, 1);
    const exact = found.length === 1 && words.length === m ? found[0] : -1;
    drawn = {
      end, most,
      x: counts.map((_, k) => k * width),
      counts,
      // One candidate among thousands is still seen.
      chosen: chosen.map((count) => count ? Math.max(count, 0.01 * most) : 0),
      exact: exact >= 0 ? all.error(exact) : null,
      points: counts.map((count, k) => ({ x: (k + 0.5) * width, y: count,
        text: `${percent(k * width)} to ${percent((k + 1) * width)}: ${count} candidates${words.length ? `, ${chosen[k]} of them with these functions` : ""}` }))
        .filter((point) => point.y),
    };
    const name = (i) => all.members(i).map((index) => functions[index]).join(", ");
    const shown = (words.length ? found : [...Array(Math.min(all.count, 5)).keys()]).slice(0, 8);
    list.replaceChildren(...shown.map((i) => {
      const item = document.createElement("li");
      item.value = i + 1;
      item.textContent = `${name(i)}: ${percent(all.error(i))}${all.ranks(i)}`;
      return item;
    }));
    output.textContent = unknown.length ? `not in the family: ${unknown.join(", ")}`
      : exact >= 0 ? `rank ${exact + 1} of ${all.all}: ${percent(all.error(exact))}${all.ranks(exact).replace(" (", ", ranks ").replace(")", " cannot be told apart")}`
      : words.length ? `${found.length} of ${all.total} candidates have these functions${found.length ? `, the best with rank ${found[0] + 1}` : ""}`
      : `${all.total} candidates; the best ones below, numbered by rank`;
    redraw?.();
  }
  size.addEventListener("input", draw);
  search.addEventListener("input", draw);
  draw();
  redraw = chart({
    holder: plot,
    label: "candidates by error",
    height: 260,
    scales: { x: { time: false, range: () => [0, drawn.end] }, y: { range: () => [0, 1.25 * drawn.most] } },
    axes: [
      { label: "mean |G - F| (further left is better)", values: percents },
      { label: "candidates", size: 60 },
    ],
    series: () => {
      const bars = (colour) => ({ fill: style(colour), width: 0, points: { show: false }, paths: uPlot.paths.bars({ size: [0.9, 100], align: 1 }) });
      return [{}, bars("--bars"), bars("--chosen")];
    },
    data: () => [drawn.x, drawn.counts, drawn.chosen],
    points: () => drawn.points,
    say: (text) => { told.textContent = text; },
    after: (u, chosen) => {
      const { ctx } = u;
      const ratio = uPlot.pxRatio;
      const bottom = u.valToPos(0, "y", true);
      const upright = (error, colour, name, row) => {
        const x = u.valToPos(error, "x", true);
        ctx.strokeStyle = ctx.fillStyle = style(colour);
        ctx.lineWidth = 2 * ratio;
        ctx.beginPath();
        ctx.moveTo(x, bottom);
        ctx.lineTo(x, u.bbox.top + 12 * row * ratio);
        ctx.stroke();
        const isLeft = error > 0.75 * drawn.end;
        ctx.textAlign = isLeft ? "right" : "left";
        ctx.textBaseline = "top";
        ctx.font = `${12 * ratio}px system-ui, sans-serif`;
        ctx.fillText(name, x + (isLeft ? -4 : 4) * ratio, u.bbox.top + 12 * row * ratio);
      };
      marks.filter(([, error]) => error < drawn.end).forEach(([name, error], i) => upright(error, "--fore", `${name} ${percent(error)}`, i % 4));
      if (drawn.exact !== null) upright(drawn.exact, "--chosen", "", 0);
      if (chosen) {
        const [left, right] = [chosen.x - drawn.end / BINS / 2, chosen.x + drawn.end / BINS / 2].map((x) => u.valToPos(x, "x", true));
        ctx.strokeStyle = style("--fore");
        ctx.lineWidth = 2 * ratio;
        ctx.strokeRect(left, u.valToPos(chosen.y, "y", true), right - left, bottom - u.valToPos(chosen.y, "y", true));
      }
    },
  });
};
