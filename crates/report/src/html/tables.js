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

