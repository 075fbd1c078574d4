// Materials of the view. What all of them share is changed in one place: `shared`.
const shared = {
  section: { value: new THREE.Vector4(0, 0, 0, 1) },  // hides what has section.xyz . p > section.w
  selected: { value: -1 },
  mark: { value: new THREE.Color() },
  viewport: { value: new THREE.Vector2(1, 1) },  // device pixels
  focal: { value: 1 },  // device pixels that a unit takes up at distance 1
};

const CUT = "uniform vec4 section; varying vec3 place; void cut() { if (dot(section.xyz, place) > section.w) discard; }";
const colours = (list) => ({ value: list.map((c) => new THREE.Color(c)) });

// Lit cells coloured by kind. `uv` draws the sides of quads, `tint` (0 to 1) takes colour away.
function surfaceMaterial(palette, hasSides) {
  return new THREE.ShaderMaterial({
    uniforms: { ...shared, palette: colours(palette), tint: { value: 0 } },
    defines: { N: palette.length, ...(hasSides ? { SIDES: 1 } : {}) },
    side: THREE.DoubleSide,
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    vertexShader: `
      attribute float kind; attribute float face; attribute vec2 corner;
      varying vec3 place, seen, turned; varying vec2 side; varying float kindOf, faceOf;
      void main() {
        vec4 world = modelMatrix * vec4(position, 1.0), view = viewMatrix * world;
        place = world.xyz; seen = view.xyz; turned = normalMatrix * normal;
        side = corner; kindOf = kind; faceOf = face;
        gl_Position = projectionMatrix * view;
      }`,
    fragmentShader: `
      ${CUT}
      uniform vec3 palette[N]; uniform vec3 mark; uniform float selected, tint;
      varying vec3 seen, turned; varying vec2 side; varying float kindOf, faceOf;
      void main() {
        cut();
        vec3 base = palette[int(kindOf + 0.5)];
        base = mix(base, vec3(0.82, 0.84, 0.86), tint);
        if (selected >= 0.0) base = abs(faceOf - selected) < 0.5 ? mark : mix(base, vec3(0.72, 0.74, 0.76), 0.65);
        #ifdef SIDES
          vec2 width = fwidth(side), edge = min(side, 1.0 - side) / max(width, 1e-6);
          float line = 1.0 - smoothstep(0.4, 1.1, min(edge.x, edge.y));
          line *= 1.0 - smoothstep(0.10, 0.28, max(width.x, width.y));
          base *= 1.0 - 0.30 * line;
        #endif
        vec3 n = normalize(turned), eye = normalize(-seen);
        float back = gl_FrontFacing ? 1.0 : 0.72;
        if (dot(n, eye) < 0.0) n = -n;
        float light = 0.56 + 0.32 * max(dot(n, eye), 0.0) + 0.24 * max(dot(n, normalize(vec3(-0.4, 0.8, 0.5))), 0.0);
        float shine = 0.10 * pow(max(dot(n, normalize(eye + vec3(-0.3, 0.7, 0.5))), 0.0), 24.0);
        gl_FragColor = vec4(base * light * back + shine, 1.0);
      }`,
  });
}

// The selected face where others hide it, as if they were glass.
const glowMaterial = new THREE.ShaderMaterial({
  uniforms: shared,
  side: THREE.DoubleSide, transparent: true, depthWrite: false, depthFunc: THREE.GreaterDepth,
  vertexShader: `
    attribute float face; varying vec3 place; varying float faceOf;
    void main() {
      vec4 world = modelMatrix * vec4(position, 1.0);
      place = world.xyz; faceOf = face; gl_Position = projectionMatrix * viewMatrix * world;
    }`,
  fragmentShader: `
    ${CUT}
    uniform vec3 mark; uniform float selected; varying float faceOf;
    void main() {
      cut();
      if (abs(faceOf - selected) > 0.5) discard;
      gl_FragColor = vec4(mark, 0.45);
    }`,
});

// The number of the face under the pointer, as a colour.
const pickMaterial = new THREE.ShaderMaterial({
  uniforms: shared,
  side: THREE.DoubleSide,
  vertexShader: `
    attribute float face; varying vec3 place; varying float faceOf;
    void main() {
      vec4 world = modelMatrix * vec4(position, 1.0);
      place = world.xyz; faceOf = face; gl_Position = projectionMatrix * viewMatrix * world;
    }`,
  fragmentShader: `
    ${CUT}
    varying float faceOf;
    void main() {
      cut();
      float id = floor(faceOf + 0.5);
      gl_FragColor = vec4(mod(id, 256.0) / 255.0, floor(id / 256.0) / 255.0, 1.0, 1.0);
    }`,
});

// Points come forward by `lift`, so that noise does not bury half of them in the surface.
const LIFT = "vec4 lifted(vec4 view, float lift) { view.xyz *= 1.0 - lift / length(view.xyz); return view; }";

function cloudMaterial(lift, diameter, limit, ramp) {
  return new THREE.ShaderMaterial({
    uniforms: {
      ...shared, lift: { value: lift }, diameter: { value: diameter }, limit: { value: limit },
      ramp: colours(ramp), unknown: { value: new THREE.Color("#8b98a3") },
    },
    vertexShader: `
      uniform float lift, diameter, limit, focal, selected; uniform vec3 ramp[5], unknown;
      attribute float deviation, face; varying vec3 place, colour;
      ${LIFT}
      void main() {
        vec4 world = modelMatrix * vec4(position, 1.0), view = lifted(viewMatrix * world, lift);
        place = world.xyz;
        float t = 2.0 + 2.0 * clamp(deviation / limit, -1.0, 1.0);
        int i = int(min(t, 3.0));
        colour = deviation > 1e29 ? unknown : mix(ramp[i], ramp[i + 1], t - float(i));
        if (selected >= 0.0 && abs(face - selected) > 0.5) colour = mix(colour, vec3(0.75, 0.77, 0.79), 0.85);
        gl_Position = projectionMatrix * view;
        gl_PointSize = clamp(diameter * focal / -view.z, 1.6, 14.0);
      }`,
    fragmentShader: `
      ${CUT}
      varying vec3 colour;
      void main() {
        cut();
        vec2 off = 2.0 * gl_PointCoord - 1.0; float r = dot(off, off);
        if (r > 1.0) discard;
        gl_FragColor = vec4(colour * (1.0 - 0.18 * r), 1.0);
      }`,
  });
}

// Discs of so many pixels with a ring round them: corners, and the marked place.
function discMaterial(lift, pixels, colour, ring, fill = 1) {
  return new THREE.ShaderMaterial({
    uniforms: { ...shared, lift: { value: lift }, pixels: { value: pixels }, colour: { value: colour }, ring: { value: ring }, fill: { value: fill } },
    transparent: true,
    vertexShader: `
      uniform float lift, pixels; varying vec3 place;
      ${LIFT}
      void main() {
        vec4 world = modelMatrix * vec4(position, 1.0);
        place = world.xyz;
        gl_Position = projectionMatrix * lifted(viewMatrix * world, lift);
        gl_PointSize = pixels;
      }`,
    fragmentShader: `
      ${CUT}
      uniform vec3 colour, ring; uniform float pixels, fill;
      void main() {
        cut();
        float r = length(2.0 * gl_PointCoord - 1.0) * pixels * 0.5, outer = 0.5 * pixels - 0.5;
        float inside = 1.0 - smoothstep(outer - 2.6, outer - 1.6, r);
        gl_FragColor = vec4(mix(ring, colour, inside), (1.0 - smoothstep(outer - 0.7, outer + 0.3, r)) * mix(1.0, fill, inside));
      }`,
  });
}

// Segments as ribbons of so many pixels: WebGL draws lines one pixel wide only.
function ribbonMaterial(lift, pixels, colour) {
  return new THREE.ShaderMaterial({
    uniforms: { ...shared, lift: { value: lift }, pixels: { value: pixels }, colour: { value: colour } },
    side: THREE.DoubleSide,
    vertexShader: `
      uniform float lift, pixels; uniform vec2 viewport;
      attribute vec3 start, end; varying vec3 place;
      ${LIFT}
      void main() {
        vec4 a = modelMatrix * vec4(start, 1.0), b = modelMatrix * vec4(end, 1.0);
        place = mix(a.xyz, b.xyz, position.x);
        vec4 p = projectionMatrix * lifted(viewMatrix * a, lift), q = projectionMatrix * lifted(viewMatrix * b, lift);
        vec2 along = (q.xy / q.w - p.xy / p.w) * viewport;
        along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
        vec2 off = pixels * (position.y * vec2(-along.y, along.x) + (position.x - 0.5) * along);
        gl_Position = position.x < 0.5 ? p : q;
        gl_Position.xy += off / viewport * gl_Position.w;
      }`,
    fragmentShader: `${CUT} uniform vec3 colour; void main() { cut(); gl_FragColor = vec4(colour, 1.0); }`,
  });
}
