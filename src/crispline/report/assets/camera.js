// A turntable camera: Z stays up. Mouse, touch and keys; nothing moves by itself.
class Turntable {
  constructor(canvas, changed, picked) {
    this.canvas = canvas;
    this.changed = changed;
    this.picked = picked;
    this.camera = new THREE.PerspectiveCamera(26, 1, 0.01, 20);
    this.camera.up.set(0, 0, 1);
    this.target = new THREE.Vector3();
    this.pointers = new Map();
    this.look("iso");
    canvas.addEventListener("pointerdown", (e) => this.down(e));
    canvas.addEventListener("pointermove", (e) => this.move(e));
    canvas.addEventListener("pointerup", (e) => this.up(e));
    canvas.addEventListener("pointercancel", (e) => this.pointers.delete(e.pointerId));
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
    canvas.addEventListener("keydown", (e) => this.key(e));
  }

  look(direction) {
    const angles = { iso: [-0.95, 0.5], x: [0, 0], y: [-Math.PI / 2, 0], z: [-Math.PI / 2, Math.PI / 2] };
    [this.yaw, this.pitch] = angles[direction];
    this.fit();
  }

  fit() {
    this.target.set(0, 0, 0);
    this.radius = 0.78;
    this.distance = null;  // depends on the shape of the window, see update()
    this.changed();
  }

  // Look at a place from the direction given.
  goTo(place, from, radius) {
    this.target.copy(place);
    this.yaw = Math.atan2(from.y, from.x);
    this.pitch = Math.max(-1.2, Math.min(1.2, Math.asin(from.z)));
    this.distance = radius / Math.sin(THREE.MathUtils.degToRad(this.camera.fov / 2));
    this.changed();
  }

  update(width, height) {
    const half = THREE.MathUtils.degToRad(this.camera.fov / 2);
    if (this.distance === null) {
      const narrow = Math.min(1, width / height);
      this.distance = this.radius / (Math.sin(half) * narrow);
    }
    const d = this.distance, c = Math.cos(this.pitch);
    const offset = new THREE.Vector3(c * Math.cos(this.yaw), c * Math.sin(this.yaw), Math.sin(this.pitch));
    this.camera.position.copy(this.target).addScaledVector(offset, d);
    this.camera.aspect = width / height;
    this.camera.near = Math.max(d - 2, 0.01 * d);
    this.camera.far = d + 3;
    // Straight from above the up direction is that of the turntable.
    this.camera.up.set(-Math.cos(this.yaw) * Math.sin(this.pitch), -Math.sin(this.yaw) * Math.sin(this.pitch), c);
    this.camera.lookAt(this.target);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.pixel = 2 * d * Math.tan(half) / height;
  }

  turn(dx, dy) {
    this.yaw -= dx;
    this.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.pitch + dy));
    this.changed();
  }

  pan(dx, dy) {
    const e = this.camera.matrixWorld.elements;
    this.target.addScaledVector(new THREE.Vector3(e[0], e[1], e[2]), -dx * this.pixel);
    this.target.addScaledVector(new THREE.Vector3(e[4], e[5], e[6]), dy * this.pixel);
    this.changed();
  }

  // What lies under (x, y), in pixels from the middle, stays there.
  zoom(factor, x = 0, y = 0) {
    const before = this.distance;
    this.distance = Math.max(0.01, Math.min(12, before * factor));
    const shift = 1 - this.distance / before;
    this.pan(-x * shift, -y * shift);
  }

  down(e) {
    this.canvas.setPointerCapture(e.pointerId);
    this.pointers.set(e.pointerId, [e.clientX, e.clientY]);
    if (this.pointers.size === 1) this.travel = 0;
  }

  move(e) {
    const last = this.pointers.get(e.pointerId);
    if (!last) return;
    const [dx, dy] = [e.clientX - last[0], e.clientY - last[1]];
    const before = this.spread();
    this.pointers.set(e.pointerId, [e.clientX, e.clientY]);
    this.travel += Math.abs(dx) + Math.abs(dy);
    if (this.pointers.size > 1) {
      this.pan(dx / 2, dy / 2);
      this.zoom(before / this.spread());
    } else if (e.buttons > 1 || e.shiftKey) this.pan(dx, dy);
    else this.turn(0.007 * dx, 0.007 * dy);
  }

  up(e) {
    const isClick = this.pointers.size === 1 && this.travel < 5 && e.button === 0;
    this.pointers.delete(e.pointerId);
    if (isClick) this.picked(e.offsetX, e.offsetY);
  }

  spread() {
    const [a, b] = [...this.pointers.values()];
    return b ? Math.hypot(a[0] - b[0], a[1] - b[1]) || 1 : 1;
  }

  wheel(e) {
    e.preventDefault();
    const pixels = e.deltaY * (e.deltaMode === 1 ? 30 : 1);
    const box = this.canvas.getBoundingClientRect();
    this.zoom(Math.exp(0.0012 * Math.max(-300, Math.min(300, pixels))),
      e.offsetX - box.width / 2, e.offsetY - box.height / 2);
  }

  key(e) {
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    if (arrows[e.key]) {
      const [x, y] = arrows[e.key];
      if (e.shiftKey) this.pan(30 * x, 30 * y); else this.turn(0.1 * x, 0.1 * y);
    } else if (e.key === "+" || e.key === "=") this.zoom(0.85);
    else if (e.key === "-") this.zoom(1 / 0.85);
    else if (e.key === "f") this.fit();
    else if (e.key === "Escape") this.picked(null);
    else return;
    e.preventDefault();
  }
}
