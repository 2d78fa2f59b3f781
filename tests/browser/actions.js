"use strict";
// A chart draws in a microtask after a change.
const drawn = () => new Promise((resolve) => setTimeout(resolve, 0));
ready.then(async () => {
  const seen = { complaints: window.complaints };
  const holder = document.querySelector(".tradeoffs");
  const filters = document.querySelector(".filters");
  const output = holder.nextElementSibling;
  const shown = () => Number(output.textContent.match(/^[0-9]+(?= of)/)?.[0]);
  const box = (text) => [...filters.querySelectorAll("label")].find((label) => label.textContent.trim() === text).querySelector("input");
  const place = holder.querySelector(".chart");
  const ink = () => {
    const canvas = place.querySelector("canvas");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let sum = 0;
    for (let i = 3; i < data.length; i += 4) sum += data[i];
    return sum;
  };
  seen.points = shown();
  const before = ink();
  box("VSM").click();
  await drawn();
  seen.without_vsm = shown();
  seen.ink_without_vsm = [ink(), before];
  box("64").click();
  seen.without_64_bits = shown();
  box("VSM").click();
  box("64").click();
  seen.points_again = shown();
  seen.panels = [...holder.children].filter((panel) => !panel.hidden).length;
  box("hard shadows").click();
  seen.panels_without = [...holder.children].filter((panel) => !panel.hidden).length;
  box("hard shadows").click();
  await drawn();
  // One tabulator stop in the chart, arrow keys from mark to mark.
  seen.chart_stops = [place, ...place.querySelectorAll("*")].filter((node) => node.tabIndex === 0).length;
  const press = (key) => place.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
  place.focus();
  press("Home");
  seen.focused = output.textContent;
  press("ArrowRight");
  seen.arrow = output.textContent !== seen.focused && document.activeElement === place;
  press("Home");
  seen.arrow_back = output.textContent === seen.focused;
  seen.is_told = place.getAttribute("aria-label");
  const focusable = "a[href], button, input, select, summary, [tabindex]";
  seen.stops = [...document.querySelectorAll(focusable)].filter((node) => node.tabIndex >= 0 && node.checkVisibility()).length;
  seen.first_headings = document.querySelectorAll("h1").length;
  const levels = [...document.querySelectorAll("h1, h2, h3, h4")].map((node) => Number(node.tagName[1]));
  seen.skipped_levels = levels.filter((level, i) => i > 0 && level > levels[i - 1] + 1).length;
  const leads = (link) => { const to = link.getAttribute("href"); return to.startsWith("http") || document.getElementById(to.slice(1)) !== null; };
  seen.dead_links = [...document.querySelectorAll("a")].filter((link) => !leads(link)).map((link) => link.getAttribute("href"));
  seen.told = document.querySelectorAll("#first .told li").length;
  seen.first_figure = document.querySelectorAll("#first .chart canvas").length;
  seen.saved = document.querySelectorAll(".figure .caption button").length;
  const search = document.querySelector("#speed-accuracy input[type=search]");
  const table = search.nextElementSibling.querySelector("table");
  const rows = () => [...table.tBodies[0].rows].filter((row) => !row.hidden);
  seen.rows = rows().length;
  search.value = "hamburger";
  search.dispatchEvent(new Event("input"));
  seen.rows_found = rows().length;
  search.value = "";
  search.dispatchEvent(new Event("input"));
  const head = [...table.tHead.rows[0].cells];
  const column = head.findIndex((cell) => cell.textContent === "cost");
  const numbers = () => rows().map((row) => parseFloat(row.cells[column].textContent));
  const rises = (values) => values.every((value, i) => i === 0 || values[i - 1] <= value);
  head[column].querySelector("button").click();
  seen.ascending = rises(numbers());
  head[column].querySelector("button").click();
  seen.descending = rises(numbers().reverse());
  const image = document.querySelector(".figure img");
  image.click();
  seen.enlarged = image.classList.contains("large");
  image.click();
  // The comparer shows PCF alone, then the technique alone: as many different pixels as the two columns have.
  const comparer = document.querySelector(".comparer");
  const canvas = comparer.querySelector("canvas");
  const [slider, zoom] = comparer.querySelectorAll("input");
  const pixels = () => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  const set = (node, value) => { node.value = value; node.dispatchEvent(new Event("input")); };
  set(slider, 100);
  const pcf = pixels();
  set(slider, 0);
  const technique = pixels();
  set(slider, 50);
  const both = pixels();
  const different = (a, b) => { let count = 0; for (let i = 0; i < a.length; i += 4) count += a[i] !== b[i]; return count; };
  seen.compared = [different(pcf, technique), different(pcf, both), different(technique, both)];
  set(zoom, 4);
  seen.zoomed = different(both, pixels());
  seen.comparer = canvas.getAttribute("aria-label");
  const right = comparer.querySelectorAll("select")[comparer.querySelectorAll("select").length - 1];
  set(zoom, 1);
  set(slider, 0);
  const plain = pixels();
  set(right, 1);
  const change = pixels();
  // Grey wherever the technique and PCF agree.
  let agree = 0;
  let grey = 0;
  for (let i = 0; i < change.length; i += 4) {
    if (pcf[i] !== plain[i] || pcf[i + 1] !== plain[i + 1] || pcf[i + 2] !== plain[i + 2]) continue;
    agree += 1;
    grey += change[i] === 128 && change[i + 1] === 128;
  }
  seen.difference = [agree, grey, different(change, plain)];
  // A candidate by its functions in any order and spelling, and one that is not there.
  const candidates = document.querySelector(".candidates");
  const find = (text) => {
    set(candidates.querySelector("input"), text);
    return candidates.querySelector("output").textContent;
  };
  seen.candidate = find("Z^3,z ,z^4, z^2");
  await drawn();
  seen.candidate_line = candidates.querySelectorAll("canvas").length;
  seen.candidates_with = find("z, z^2");
  seen.no_candidate = find("z, tan(z)");
  seen.listed = (find("z"), candidates.querySelectorAll("li").length);
  // Values under the pointer: a mark of a chart, a cell of a grid.
  const tip = document.querySelector(".tip");
  const point = (node) => {
    const box = node.getBoundingClientRect();
    node.dispatchEvent(new PointerEvent("pointermove", { bubbles: true, clientX: box.left + box.width / 2, clientY: box.top + box.height / 2 }));
    return tip.hidden ? "" : tip.textContent;
  };
  seen.spot = point(document.querySelector(".figure .spot"));
  seen.cell = point(document.querySelector(".figure .grid"));
  document.body.dispatchEvent(new PointerEvent("pointermove", { bubbles: true }));
  seen.tip_left = tip.hidden;
  seen.papers = document.querySelectorAll("#papers tbody tr").length;
  seen.figures = document.querySelectorAll(".figure").length;
  // As narrow as a phone, everything drawn.
  const style = document.createElement("style");
  style.textContent = "html { width: 360px; } main > section { content-visibility: visible !important; } details { content-visibility: visible; }";
  document.head.append(style);
  document.querySelectorAll("details").forEach((details) => { details.open = true; });
  // Charts follow their place when the page is next laid out, which a busy machine does late: what stays wide is wide.
  for (let turn = 0; turn < 150 && document.body.scrollWidth > 360; turn++) await new Promise((resolve) => setTimeout(resolve, 20));
  seen.width = document.body.scrollWidth;
  // What stands out, for the one who has to mend it; what scrolls by itself may be wider.
  const scrolls = (node) => node && (getComputedStyle(node).overflowX !== "visible" || scrolls(node.parentElement));
  seen.too_wide = [...document.body.querySelectorAll("*")]
    .filter((node) => node.getBoundingClientRect().right > 360 && !scrolls(node.parentElement))
    .map((node) => `${node.localName}.${node.getAttribute("class")}: ${node.textContent.slice(0, 40)}`)
    .slice(0, 8);
  const sizes = [...document.querySelectorAll("svg text")].map((text) => {
    const svg = text.closest("svg");
    return parseFloat(getComputedStyle(text).fontSize) * svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
  });
  seen.smallest_text = Math.min(...sizes);
  const note = document.createElement("pre");
  note.id = "seen";
  note.textContent = JSON.stringify(seen);
  document.body.append(note);
}).catch((error) => {
  const note = document.createElement("pre");
  note.id = "seen";
  note.textContent = JSON.stringify({ complaints: [`${error}`] });
  document.body.append(note);
});
