// Frames that play: a button, or the slider's own keys. Nothing moves before it is asked to, and with reduced motion the button
// goes on by one frame.
for (const film of document.querySelectorAll(".film")) {
  const image = film.querySelector("img");
  const frames = JSON.parse(film.dataset.frames);
  const still = window.matchMedia("(prefers-reduced-motion: reduce)");
  const controls = document.createElement("div");
  controls.className = "controls";
  const button = document.createElement("button");
  button.type = "button";
  const slider = document.createElement("input");
  Object.assign(slider, { type: "range", min: 0, max: frames.length - 1, step: 1, value: 0 });
  slider.setAttribute("aria-label", `frame of: ${image.alt}`);
  const told = document.createElement("span");
  controls.append(button, slider, told);
  image.after(controls);
  let timer = 0;
  const show = (index) => {
    slider.value = index;
    image.style.objectPosition = `0 ${100 * index / Math.max(1, frames.length - 1)}%`;
    told.textContent = `frame ${frames[index]}`;
    slider.setAttribute("aria-valuetext", told.textContent);
  };
  const next = () => show((Number(slider.value) + 1) % frames.length);
  const label = () => { button.textContent = timer ? "Pause" : still.matches ? "Next frame" : "Play"; };
  const stop = () => {
    clearInterval(timer);
    timer = 0;
    label();
  };
  button.addEventListener("click", () => {
    if (timer) {
      stop();
    } else if (still.matches) {
      next();
    } else {
      timer = setInterval(next, 125);
      label();
    }
  });
  slider.addEventListener("input", () => {
    stop();
    show(Number(slider.value));
  });
  still.addEventListener("change", stop);
  // What nobody sees need not go on.
  new IntersectionObserver(([entry]) => { if (!entry.isIntersecting && timer) stop(); }).observe(film);
  show(0);
  label();
}
