// The values that the page carries: numbers, and typed arrays in base64.
const data = JSON.parse(document.getElementById("data").textContent);
const NO_FACE = 65535;

function typedArray(name) {
  const stored = data.arrays[name];
  if (!stored) return null;
  const text = atob(stored.base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
  const type = { Float32Array, Uint8Array, Uint16Array, Uint32Array }[stored.type];
  return new type(bytes.buffer);
}

// Whole numbers of three bytes each, the lowest first.
function wholeNumbers(name) {
  const bytes = typedArray(name), numbers = new Uint32Array(bytes.length / 3);
  for (let i = 0; i < numbers.length; i++) {
    numbers[i] = bytes[3 * i] | (bytes[3 * i + 1] << 8) | (bytes[3 * i + 2] << 16);
  }
  return numbers;
}

// The view works in a cube of side 1 about the origin; these map to it and back.
const toView = (place) => new THREE.Vector3(...place.map((x, i) => (x - data.origin[i]) / data.extent - 0.5));
const lengthToView = (length) => length / data.extent;

// Normals at the corners of cells (triangles, quads): the mean of the cells round the vertex
// that turn less than `limit` (cosine) from the cell itself, so creases stay creases.
function cornerNormals(positions, cells, size, limit) {
  const nCells = cells.length / size, nVertices = positions.length / 3;
  const flat = new Float32Array(3 * nCells), count = new Uint32Array(nVertices + 1);
  for (let c = 0; c < nCells; c++) {
    // Half the cross product of the diagonals of a quad, of two sides of a triangle.
    const [a, b, p, q] = size === 4 ? [0, 2, 1, 3] : [0, 1, 0, 2];
    const at = (k) => 3 * cells[size * c + k];
    const d = [0, 1, 2].map((i) => positions[at(b) + i] - positions[at(a) + i]);
    const e = [0, 1, 2].map((i) => positions[at(q) + i] - positions[at(p) + i]);
    for (let i = 0; i < 3; i++) {
      const j = (i + 1) % 3, k = (i + 2) % 3;
      flat[3 * c + i] = d[j] * e[k] - d[k] * e[j];
    }
    for (let k = 0; k < size; k++) count[cells[size * c + k] + 1]++;
  }
  for (let v = 0; v < nVertices; v++) count[v + 1] += count[v];
  const around = new Uint32Array(cells.length), next = count.slice(0, nVertices);
  for (let h = 0; h < cells.length; h++) around[next[cells[h]]++] = Math.floor(h / size);
  const normals = new Int8Array(4 * cells.length);
  for (let h = 0; h < cells.length; h++) {
    const own = 3 * Math.floor(h / size), sum = [0, 0, 0];
    const ownLength = Math.hypot(flat[own], flat[own + 1], flat[own + 2]) || 1;
    for (let n = count[cells[h]]; n < count[cells[h] + 1]; n++) {
      const f = 3 * around[n];
      const dot = flat[f] * flat[own] + flat[f + 1] * flat[own + 1] + flat[f + 2] * flat[own + 2];
      const length = Math.hypot(flat[f], flat[f + 1], flat[f + 2]);
      if (f !== own && dot < limit * length * ownLength) continue;
      for (let i = 0; i < 3; i++) sum[i] += flat[f + i];
    }
    const length = Math.hypot(...sum) || 1;
    for (let i = 0; i < 3; i++) normals[4 * h + i] = Math.round(127 * sum[i] / length);
  }
  return normals;
}
