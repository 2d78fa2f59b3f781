// Pictures: click or Enter for their own size.
for (const figure of document.querySelectorAll(".figure")) {
  const image = figure.querySelector("img");
  if (!image) continue;
  const toggle = () => image.classList.toggle("large");
  image.addEventListener("click", toggle);
  figure.addEventListener("keydown", (event) => { if (event.key === "Enter") toggle(); });
}

// Figures that were drawn: saved as SVG or PNG, by buttons for a pointer and by the keys s and p; no stops of their own.
for (const figure of document.querySelectorAll("p > .figure")) {
  const svg = figure.querySelector("svg");
  if (!svg) continue;
  const caption = figure.querySelector(".caption");
  const name = caption.textContent.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "").slice(0, 60);
  const download = (address, kind) => Object.assign(document.createElement("a"), { href: address, download: `${name}.${kind}` }).click();
  // On white paper, whatever the page has.
  const document_ = () => {
    const copy = svg.cloneNode(true);
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    copy.setAttribute("font-family", "sans-serif");
    copy.querySelectorAll(".spot, .grid").forEach((node) => node.remove());
    return `data:image/svg+xml;charset=utf-8,${encodeURIComponent(new XMLSerializer().serializeToString(copy))}`;
  };
  const save = {
    svg: () => download(document_(), "svg"),
    png: () => {
      const image = new Image();
      image.addEventListener("load", () => {
        const canvas = document.createElement("canvas");
        // Twice the size, for print.
        [canvas.width, canvas.height] = [2 * svg.width.baseVal.value, 2 * svg.height.baseVal.value];
        canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
        download(canvas.toDataURL("image/png"), "png");
      });
      image.src = document_();
    },
  };
  for (const kind of ["svg", "png"]) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", textContent: kind.toUpperCase(), tabIndex: -1 });
    button.setAttribute("aria-label", `save as ${kind.toUpperCase()}`);
    button.addEventListener("click", save[kind]);
    caption.append(button);
  }
  figure.setAttribute("aria-keyshortcuts", "s p");
  figure.addEventListener("keydown", (event) => {
    const kind = { s: "svg", p: "png" }[event.key];
    if (kind && !event.ctrlKey && !event.metaKey && !event.altKey) save[kind]();
  });
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

