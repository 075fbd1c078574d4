// What is drawn over the view: axes, scale, colour bar, legend.
const AXES = [["X", "#d0473c"], ["Y", "#3f9a52"], ["Z", "#3f7fd1"]];
const nice = (x) => { const p = 10 ** Math.floor(Math.log10(x)); return [5, 2, 1].find((k) => k * p <= x * 1.0001) * p; };
const short = (x) => Number(x.toPrecision(3)).toString().replace("-", "\u2212");

function drawTriad(camera) {
  const e = camera.matrixWorldInverse.elements;
  const tips = AXES.map(([name, colour], i) => ({ name, colour, x: e[4 * i], y: -e[4 * i + 1], z: e[4 * i + 2] }));
  document.getElementById("triad").innerHTML = tips.sort((a, b) => a.z - b.z).map((t) =>
    `<line x2="${24 * t.x}" y2="${24 * t.y}" stroke="${t.colour}"/>` +
    `<text x="${34 * t.x}" y="${34 * t.y + 6}" text-anchor="middle">${t.name}</text>`).join("");
}

function drawScale(pixel) {
  const length = nice(110 * pixel * data.extent), [text, bar] = document.getElementById("scale").children;
  text.textContent = `${short(length)}${data.unit ? " " + data.unit : ""}`;
  bar.style.width = `${length / (pixel * data.extent)}px`;
}

function drawBar(limit) {
  document.querySelector(".ramp").style.background = `linear-gradient(to top, ${data.ramp.join(", ")})`;
  const ticks = [1, 0.5, 0, -0.5, -1].map((k) => (k > 0 ? "+" : "") + short(k * limit));
  if (data.unit) ticks[0] = `${data.unit}  ${ticks[0]}`;
  document.getElementById("ticks").replaceChildren(...ticks.map((t) => Object.assign(document.createElement("span"), { textContent: t })));
}

function drawLegend(on) {
  const rows = [];
  if (on.model && !on.cloud && !on.patches) {
    const used = new Set(data.face_kinds);
    data.kinds.forEach((kind, i) => { if (used.has(i)) rows.push([kind, data.kind_colours[i]]); });
  }
  if (on.patches) ["flat", "curved", "sharp"].forEach((kind, i) => rows.push([`${kind} patch`, data.patch_colours[i]]));
  document.getElementById("legend").replaceChildren(...rows.map(([text, colour]) => {
    const row = document.createElement("span"), box = document.createElement("i");
    box.style.background = colour;
    row.append(box, text);
    return row;
  }));
}
