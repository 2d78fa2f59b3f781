"use strict";
{
  const seen = { complaints: window.complaints };
  const explorer = document.querySelector(".explorer");
  const marks = () => explorer.querySelectorAll("circle").length;
  const box = (text) => [...explorer.querySelectorAll("label")].find((label) => label.textContent.trim() === text).querySelector("input");
  seen.points = marks();
  box("VSM").click();
  seen.without_vsm = marks();
  box("64").click();
  seen.without_64_bits = marks();
  box("VSM").click();
  box("64").click();
  seen.points_again = marks();
  const output = explorer.querySelector("output");
  const first = explorer.querySelector("circle");
  first.dispatchEvent(new MouseEvent("mouseenter"));
  seen.hovered = output.textContent;
  output.textContent = "";
  first.focus();
  first.dispatchEvent(new FocusEvent("focus"));
  seen.focused = output.textContent;
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
  seen.candidate_line = candidates.querySelectorAll("svg line").length;
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
  seen.overflows = document.documentElement.scrollWidth > document.documentElement.clientWidth + 1;
  const note = document.createElement("pre");
  note.id = "seen";
  note.textContent = JSON.stringify(seen);
  document.body.append(note);
}
