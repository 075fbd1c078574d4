// Draws the layers, finds the face under the pointer, makes pictures of places.
class View {
  constructor(canvas, drawn, picked) {
    this.canvas = canvas;
    this.drawn = drawn;
    this.picked = picked;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setClearColor(0, 0);
    this.renderer.autoClear = false;
    this.scene = new THREE.Scene();
    this.layers = {};
    this.on = {};
    this.wipe = false;
    this.divider = 0.5;
    this.turntable = new Turntable(canvas, () => this.invalidate(), (x, y) => this.pick(x, y));
    this.marker = pointsObject(new Uint16Array(3), discMaterial(0.05, 26 * ratio, ink.edge, shared.mark.value, 0));
    this.marker.material.depthTest = false;
    this.marker.visible = false;
    this.scene.add(this.marker);
    this.pixel = new THREE.WebGLRenderTarget(1, 1);
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width && height) this.setSize(width, height, ratio);
    this.invalidate();
  }

  setSize(width, height, pixelRatio) {
    this.renderer.setPixelRatio(pixelRatio);
    this.renderer.setSize(width, height, false);
    [this.width, this.height] = [width, height];
    shared.viewport.value.set(width * pixelRatio, height * pixelRatio);
    shared.focal.value = height * pixelRatio / (2 * Math.tan(THREE.MathUtils.degToRad(this.turntable.camera.fov / 2)));
  }

  invalidate() {
    if (this.waiting || !this.renderer) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); this.drawn(this); });
  }

  layer(name) {
    if (!this.layers[name]) this.scene.add(this.layers[name] = BUILDERS[name]());
    return this.layers[name];
  }

  show(states) {
    Object.assign(this.on, states);
    this.invalidate();
  }

  draw() {
    if (!this.width) return;
    const { renderer, turntable, on } = this;
    for (const name in BUILDERS) {
      const wanted = { plain: on.patches && on.wipe, glow: on.model && shared.selected.value >= 0 }[name] ?? on[name];
      if (wanted) this.layer(name);
      if (this.layers[name]) this.layers[name].visible = Boolean(wanted);
    }
    // The colours of one layer shall not disturb those of another.
    const tint = { model: on.cloud ? 0.85 : 0, patches: on.wipe ? 0.5 : 0, plain: 0.5 };
    for (const name in tint) if (this.layers[name]) this.layers[name].material.uniforms.tint.value = tint[name];
    turntable.update(this.width, this.height);
    renderer.setScissorTest(false);
    renderer.clear();
    if (!(on.patches && on.wipe)) return renderer.render(this.scene, turntable.camera);
    const split = Math.round(8 + this.divider * (this.width - 16));  // where the thumb is
    renderer.setScissorTest(true);
    for (const [name, from, width] of [["plain", 0, split], ["patches", split + 1, this.width - split - 1]]) {
      this.layers.plain.visible = name === "plain";
      this.layers.patches.visible = name === "patches";
      renderer.setScissor(from, 0, Math.max(width, 0), this.height);
      renderer.render(this.scene, turntable.camera);
    }
    renderer.setScissorTest(false);
  }

  // The face at a pixel of the canvas, or null.
  faceAt(x, y) {
    if (!this.on.model || !has("model")) return null;
    const { renderer, turntable: { camera } } = this, visible = this.scene.children.map((o) => o.visible);
    const model = this.layer("model"), material = model.material;
    this.scene.children.forEach((o) => { o.visible = o === model; });
    model.material = pickMaterial;
    camera.setViewOffset(this.width, this.height, Math.floor(x), Math.floor(y), 1, 1);
    renderer.setRenderTarget(this.pixel);
    renderer.clear();
    renderer.render(this.scene, camera);
    const bytes = new Uint8Array(4);
    renderer.readRenderTargetPixels(this.pixel, 0, 0, 1, 1, bytes);
    renderer.setRenderTarget(null);
    camera.clearViewOffset();
    model.material = material;
    this.scene.children.forEach((o, i) => { o.visible = visible[i]; });
    const face = bytes[0] + 256 * bytes[1];
    return bytes[2] === 255 && face !== NO_FACE ? face : null;
  }

  pick(x, y) {
    this.picked(x === null ? null : this.faceAt(x, y));
  }

  mark(place) {
    this.marker.visible = place !== null;
    if (place) this.marker.position.copy(toView(place));
    this.marker.updateMatrixWorld();
    this.invalidate();
  }

  goTo(place) {
    this.mark(place);
    const at = toView(place);
    this.turntable.goTo(at, this.outward(at), Math.min(0.5, lengthToView(18 * data.spacing)));
  }

  // Mean normal of the model near a place, from where it can be seen.
  outward(at) {
    const sum = at.clone().multiplyScalar(1e-3), vertex = new THREE.Vector3();
    if (has("model")) {
      const { position, normal } = this.layer("model").geometry.attributes;
      const [x, y, z] = at.toArray().map((value) => 65535 * (value + 0.5)), all = position.array;
      const near = (k) => Math.hypot(all[3 * k] - x, all[3 * k + 1] - y, all[3 * k + 2] - z);
      let nearest = Infinity;
      for (let k = 0; k < position.count; k++) nearest = Math.min(nearest, near(k));
      for (let k = 0; k < position.count; k++) if (near(k) < nearest + 100) sum.add(vertex.fromBufferAttribute(normal, k));
    }
    return sum.normalize();
  }

  // A PNG of the view, or of a place in the size given.
  picture(place, width, height) {
    if (!place) { this.draw(); return this.canvas.toDataURL("image/png"); }
    const { turntable } = this, kept = { ...turntable, target: turntable.target.clone() };
    const isMarked = this.marker.visible;
    const [before, size] = [{ ...this.on }, [this.width, this.height]];
    this.setSize(width, height, 2);
    this.on = { model: has("model"), sharp: true, corners: true, patches: !has("model") && has("patches") };
    this.goTo(place);
    this.draw();
    const url = this.canvas.toDataURL("image/png");
    this.on = before;
    Object.assign(turntable, kept);
    this.marker.visible = isMarked;
    this.setSize(...size, ratio);
    this.invalidate();
    return url;
  }
}
