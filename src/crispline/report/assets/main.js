// Puts the parts together.
const byId = (id) => document.getElementById(id);
const root = document.documentElement;
const PRESETS = {
  model: { model: true, sharp: true, corners: true },
  deviation: { model: true, sharp: true, cloud: true },
  patches: { patches: true },
  wipe: { patches: true, wipe: true },
};
let view = null;

function setTheme(theme) {
  root.dataset.theme = theme;
  byId("theme").textContent = theme === "dark" ? "Light" : "Dark";
  const style = getComputedStyle(root), colour = (name) => style.getPropertyValue(name).trim();
  if (!view) return;
  ink.edge.set(colour("--edge"));
  ink.tangent.set(colour("--tangent"));
  ink.ring.set(colour("--paper"));
  shared.mark.value.set(colour("--mark"));
  view.invalidate();
}

function select(face) {
  table.select(face);
  shared.selected.value = face ?? -1;
  view?.invalidate();
}

function apply(states) {
  view.show(states);
  for (const box of document.querySelectorAll("[data-layer]")) box.checked = Boolean(view.on[box.dataset.layer]);
  const isWipe = Boolean(view.on.wipe && view.on.patches);
  byId("divider").hidden = byId("sides").hidden = !isWipe;
  byId("bar").hidden = !(view.on.cloud && has("model"));
  drawLegend(view.on);
  for (const button of document.querySelectorAll("[data-preset]")) {
    const preset = PRESETS[button.dataset.preset];
    const isOn = Object.keys(NEEDS).every((name) => Boolean(view.on[name]) === Boolean(preset[name] && has(name)));
    button.setAttribute("aria-pressed", isOn);
  }
}

function applyPreset(name) {
  const states = {};
  for (const layer in NEEDS) states[layer] = Boolean(PRESETS[name][layer] && has(layer));
  apply(states);
}

function setSection() {
  const axis = byId("section-axis").value, slider = byId("section-place"), k = "XYZ".indexOf(axis);
  slider.hidden = !axis;
  const normal = [0, 1, 2].map((i) => (i === k ? 1 : 0));
  shared.section.value.set(...normal, axis ? slider.value - 0.5 : 1);
  view.invalidate();
}

function setRange() {
  const limit = data.limit * 10 ** Number(byId("range").value);
  view.layer("cloud").material.uniforms.limit.value = limit;
  drawBar(limit);
  view.invalidate();
}

function connect() {
  for (const box of document.querySelectorAll("[data-layer]")) {
    box.disabled = !has(box.dataset.layer);
    box.addEventListener("change", () => {
      const states = { [box.dataset.layer]: box.checked };
      if (box.dataset.layer === "wipe" && box.checked) states.patches = true;
      apply(states);
    });
  }
  for (const button of document.querySelectorAll("[data-preset]")) {
    button.disabled = !Object.keys(PRESETS[button.dataset.preset]).some(has);
    button.addEventListener("click", () => applyPreset(button.dataset.preset));
  }
  for (const button of document.querySelectorAll("[data-look]")) {
    button.addEventListener("click", () => { view.mark(null); view.turntable.look(button.dataset.look); });
  }
  byId("divider").addEventListener("input", (e) => { view.divider = Number(e.target.value); view.invalidate(); });
  byId("section-axis").addEventListener("change", setSection);
  byId("section-place").addEventListener("input", setSection);
  byId("range").addEventListener("input", setRange);
  byId("save").addEventListener("click", () => {
    Object.assign(document.createElement("a"), { href: view.picture(), download: "crispline.png" }).click();
  });
  for (const button of document.querySelectorAll("[data-place]")) {
    const place = button.dataset.place.split(",").map(Number);
    button.addEventListener("click", () => view.goTo(place));
  }
}

// Pictures of the places that warnings name, after the first picture of the whole; one at a
// time, so that the page stays alive.
function drawPlaces(buttons = [...document.querySelectorAll("[data-place]")]) {
  const button = buttons.shift();
  if (!button) {
    root.dataset.places = "drawn";
    return;
  }
  const place = button.dataset.place.split(",").map(Number);
  button.style.backgroundImage = `url(${view.picture(place, 120, 80)})`;
  setTimeout(drawPlaces, 0, buttons);
}

function firstPicture() {
  if (root.dataset.ready || !view.width) return;
  root.dataset.ready = Math.round(performance.now());
  setTimeout(drawPlaces);
}

// The text is painted before the picture is begun: a graphics context may take a second.
function start() {
  try {
    view = new View(byId("view"), () => {
      drawTriad(view.turntable.camera);
      drawScale(view.turntable.pixel);
      firstPicture();
    }, select);
  } catch (error) {
    byId("notice").textContent = "This browser offers no WebGL, so there is no picture; everything else is on this page.";
    byId("notice").hidden = false;
    return;
  }
  setTheme(root.dataset.theme);
  connect();
  drawBar(data.limit);
  applyPreset(has("model") ? "model" : has("patches") ? "patches" : "deviation");
}

const table = new FaceTable(select);
setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
byId("theme").addEventListener("click", () => setTheme(root.dataset.theme === "dark" ? "light" : "dark"));
if (matchMedia("(max-width: 900px)").matches) byId("layers").open = false;
requestAnimationFrame(() => setTimeout(start));
