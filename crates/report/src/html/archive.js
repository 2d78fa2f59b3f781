// What the script alone needs comes deflated. `ready` when values under the pointer and candidates are there.
const ready = (async () => {
  // All of them, before charts take the places of some.
  const drawings = [...document.querySelectorAll("svg[data-shapes]")];
  const packed = Uint8Array.from(atob(document.getElementById("archive").textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const archive = JSON.parse(await new Response(stream).text());
  drawings.forEach((svg, i) => svg.insertAdjacentHTML("beforeend", archive.shapes[i]));
  const text = document.createElement("textarea");
  document.querySelectorAll(".candidates").forEach((holder, i) => {
    text.innerHTML = archive.candidates[i];
    candidates(holder, JSON.parse(text.value));
  });
})();
