// What can be switched on and off. Each layer is built when it is first shown.
const ink = { edge: new THREE.Color(), tangent: new THREE.Color(), ring: new THREE.Color() };
const ratio = Math.min(window.devicePixelRatio || 1, 2);
const lift = Math.min(lengthToView(Math.max(1.2 * data.limit, 0.6 * data.spacing)), 0.02);

const attribute = (array, size, normalised = false) => new THREE.BufferAttribute(array, size, normalised);

// Positions are 16-bit shares of the cube; the object brings them to the view's frame.
function placed(object) {
  object.position.set(-0.5, -0.5, -0.5);
  object.frustumCulled = false;
  object.updateMatrixWorld();
  return object;
}

function pointsObject(positions, material) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", attribute(positions, 3, true));
  return placed(new THREE.Points(geometry, material));
}

function modelLayer() {
  const positions = typedArray("vertices"), triangles = typedArray("triangles"), faces = typedArray("vertex_faces");
  const corners = cornerNormals(positions, triangles, 3, -2);
  const normals = new Int8Array(4 * faces.length);  // faces share no vertex: one normal each
  triangles.forEach((v, h) => normals.set(corners.subarray(4 * h, 4 * h + 3), 4 * v));
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", attribute(positions, 3, true));
  geometry.setAttribute("normal", new THREE.InterleavedBufferAttribute(new THREE.InterleavedBuffer(normals, 4), 3, 0, true));
  geometry.setAttribute("face", attribute(faces, 1));
  const other = data.kinds.length - 1;
  geometry.setAttribute("kind", attribute(Uint8Array.from(faces, (f) => data.face_kinds[f] ?? other), 1));
  geometry.setIndex(attribute(triangles, 1));
  return placed(new THREE.Mesh(geometry, surfaceMaterial(data.kind_colours, false)));
}

function cloudLayer() {
  const material = cloudMaterial(lift, lengthToView(0.85 * data.spacing), data.limit, data.ramp);
  const points = pointsObject(typedArray("points"), material);
  points.geometry.setAttribute("deviation", attribute(typedArray("deviations"), 1));
  points.geometry.setAttribute("face", attribute(typedArray("point_faces"), 1));
  return points;
}

function edgeLayer(name, pixels, colour) {
  const geometry = new THREE.InstancedBufferGeometry();
  geometry.setAttribute("position", attribute(new Float32Array([0, -1, 0, 1, -1, 0, 1, 1, 0, 0, 1, 0]), 3));
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  const segments = new THREE.InstancedInterleavedBuffer(typedArray(name), 6);
  geometry.setAttribute("start", new THREE.InterleavedBufferAttribute(segments, 3, 0, true));
  geometry.setAttribute("end", new THREE.InterleavedBufferAttribute(segments, 3, 3, true));
  geometry.instanceCount = segments.count;
  return placed(new THREE.Mesh(geometry, ribbonMaterial(1.5 * lift, pixels * ratio, colour)));
}

function cornerLayer() {
  return pointsObject(typedArray("corners"), discMaterial(1.8 * lift, 11 * ratio, ink.edge, ink.ring));
}

// Every quad has its own four vertices: a colour of its own, and normals on both sides of a crease.
function patchLayer(name, limit) {
  const positions = typedArray(name), quads = wholeNumbers("quads"), kinds = typedArray("patch_kinds");
  const n = quads.length, corners = new Uint16Array(3 * n), index = new Uint32Array(6 * kinds.length);
  const kind = new Uint8Array(n), corner = new Uint8Array(2 * n);
  for (let h = 0; h < n; h++) {
    for (let i = 0; i < 3; i++) corners[3 * h + i] = positions[3 * quads[h] + i];
    kind[h] = kinds[h >> 2];
    corner[2 * h] = [0, 255, 255, 0][h & 3];
    corner[2 * h + 1] = [0, 0, 255, 255][h & 3];
  }
  for (let q = 0; q < kinds.length; q++) index.set([4 * q, 4 * q + 1, 4 * q + 2, 4 * q, 4 * q + 2, 4 * q + 3], 6 * q);
  const normals = new THREE.InterleavedBuffer(cornerNormals(positions, quads, 4, limit), 4);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", attribute(corners, 3, true));
  geometry.setAttribute("normal", new THREE.InterleavedBufferAttribute(normals, 3, 0, true));
  geometry.setAttribute("kind", attribute(kind, 1));
  geometry.setAttribute("face", attribute(new Uint16Array(n).fill(NO_FACE), 1));
  geometry.setAttribute("corner", attribute(corner, 2, true));
  geometry.setIndex(attribute(index, 1));
  return placed(new THREE.Mesh(geometry, surfaceMaterial(data.patch_colours, true)));
}

const BUILDERS = {
  model: modelLayer,
  cloud: cloudLayer,
  sharp: () => edgeLayer("sharp_edges", 2.2, ink.edge),
  tangent: () => edgeLayer("tangent_edges", 1.2, ink.tangent),
  corners: cornerLayer,
  glow: () => placed(new THREE.Mesh(view.layer("model").geometry, glowMaterial)),
  patches: () => patchLayer("sharp", Math.cos(0.6)),
  plain: () => patchLayer("plain", -2),
};
const NEEDS = {
  model: "triangles", cloud: "points", sharp: "sharp_edges", tangent: "tangent_edges",
  corners: "corners", patches: "quads", wipe: "quads",
};
const has = (layer) => (data.arrays[NEEDS[layer]]?.base64.length ?? 0) > 0;
