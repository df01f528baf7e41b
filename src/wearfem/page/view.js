// The worn face in three dimensions: WebGL 2 and nothing else. Lengths in mm, taken from the middle of the first frame.
"use strict";
(() => {
  const stage = document.querySelector("#view .stage");
  const canvas = stage.querySelector("canvas");
  const gl = canvas.getContext("webgl2", { antialias: true });
  if (!gl) return; // the maps stay

  const content = JSON.parse(document.getElementById("data").textContent);
  const bytes = (text) => Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
  const numbers = (Kind, text) => new Kind(bytes(text).buffer);
  const colours = bytes(content.colours);
  let triangle = null;
  const frames = content.frames.map((told) => {
    if (told.triangle) triangle = numbers(Uint32Array, told.triangle);
    return {
      title: told.title,
      triangle,
      point: numbers(Float32Array, told.point),
      thickness: numbers(Float32Array, told.thickness),
      depth: numbers(Float32Array, told.depth),
    };
  });

  const slider = stage.querySelector("input");
  const output = stage.querySelector("output");
  const field = stage.querySelector("select");
  const value = stage.querySelector(".value");
  slider.max = frames.length - 1;
  slider.value = frames.length - 1;

  // ---- the eye: it looks at the middle, turned by rows right, up and toward, from far enough to see all
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => { const length = Math.hypot(...a); return a.map((x) => x / length); };
  const size = Math.max(...Array.from({ length: frames[0].point.length / 3 }, (_, n) => Math.hypot(...frames[0].point.slice(3 * n, 3 * n + 3))));

  function front() { // obliquely against the mean normal of the face
    const { point, triangle } = frames[0];
    let mean = [0, 0, 0];
    for (let t = 0; t < triangle.length; t += 3) {
      const [a, b, c] = corners(point, triangle, t);
      mean = mean.map((x, k) => x + cross(minus(b, a), minus(c, a))[k]);
    }
    const normal = Math.hypot(...mean) > 1e-9 * size * size ? unit(mean) : [0, 0, 1];
    let up = Math.abs(normal[2]) > 0.9 ? [0, 1, 0] : [0, 0, 1];
    let right = unit(cross(up, normal));
    up = cross(normal, right);
    const toward = unit(normal.map((x, k) => x + 0.4 * right[k] - 0.8 * up[k]));
    if (Math.abs(toward[2]) < 0.95) up = [0, 0, 1];
    right = unit(cross(up, toward));
    return [right, cross(toward, right), toward];
  }
  const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const corners = (point, triangle, t) => [0, 1, 2].map((k) => { const n = 3 * triangle[t + k]; return [point[n], point[n + 1], point[n + 2]]; });

  function fit() { // how near, so that the face fills the picture beside the legend
    let wide = 0, high = 0;
    const { point } = frames[0];
    for (let n = 0; n < point.length; n += 3) {
      const p = point.subarray(n, n + 3);
      wide = Math.max(wide, Math.abs(dot(eye[0], p)));
      high = Math.max(high, Math.abs(dot(eye[1], p)));
    }
    const { clientWidth, clientHeight } = canvas, least = Math.min(clientWidth, clientHeight);
    return 0.9 * size * Math.min((clientWidth - 150) / least / wide, clientHeight / least / high);
  }

  let eye = front();
  let near = 1; // 1: the sphere around the face fills the picture
  let shift = [0, 0]; // of the middle, in parts of what is seen

  function turn(right, up) { // [rad]
    const about = (rows, i, j, angle) => {
      const c = Math.cos(angle), s = Math.sin(angle), a = rows[i], b = rows[j];
      rows[i] = a.map((x, k) => c * x - s * b[k]);
      rows[j] = a.map((x, k) => s * x + c * b[k]);
    };
    about(eye, 0, 2, right);
    about(eye, 1, 2, up);
    eye[2] = unit(eye[2]);
    eye[0] = unit(cross(eye[1], eye[2]));
    eye[1] = cross(eye[2], eye[0]);
    draw();
  }

  // ---- what the graphics processor does: place the corners, colour by value, shade by the angle to the eye
  const program = gl.createProgram();
  for (const [kind, source] of [
    [gl.VERTEX_SHADER, `#version 300 es
      in vec3 place; in float amount; uniform mat3 eye; uniform vec2 scale, shift; uniform float depth;
      out vec3 seen; flat out float told;
      void main() { seen = eye * place; told = amount; gl_Position = vec4(seen.xy * scale + shift, -seen.z * depth, 1.0); }`],
    [gl.FRAGMENT_SHADER, `#version 300 es
      precision highp float;
      in vec3 seen; flat in float told; uniform sampler2D colours; uniform vec2 limits; uniform int line; out vec4 colour;
      void main() {
        if (line == 1) { colour = vec4(0.12, 0.16, 0.21, 1.0); return; }
        vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
        float light = 0.62 + 0.38 * abs(dot(normal, normalize(vec3(0.25, 0.35, 0.9))));
        vec3 paint = texture(colours, vec2(clamp((told - limits.x) / (limits.y - limits.x), 0.002, 0.998), 0.5)).rgb;
        colour = vec4((told > -1e29 ? paint : vec3(0.72)) * light, 1.0);
      }`],
  ]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return;
  gl.useProgram(program);
  const at = (name) => gl.getUniformLocation(program, name);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, colours);
  for (const [what, how] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR], [gl.TEXTURE_MAG_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]])
    gl.texParameteri(gl.TEXTURE_2D, what, how);
  const buffers = {};
  for (const [name, width] of [["place", 3], ["amount", 1]]) {
    buffers[name] = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers[name]);
    const place = gl.getAttribLocation(program, name);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, width, gl.FLOAT, false, 0, 0);
  }
  gl.enable(gl.DEPTH_TEST);

  const frame = () => frames[Number(slider.value)];
  let loaded = 0; // corners of the frame that is shown
  let outlined = 0; // ends of its border, behind them

  function border(triangle) { // corners of the edges that belong to one triangle only
    const seen = new Map();
    triangle.forEach((a, k) => {
      const b = triangle[k % 3 === 2 ? k - 2 : k + 1], name = a < b ? `${a} ${b}` : `${b} ${a}`;
      seen.set(name, seen.has(name) ? null : [a, b]);
    });
    return [...seen.values()].filter(Boolean).flat();
  }

  function load() {
    const { point, triangle, title } = frame();
    const amount = frame()[field.value];
    const place = new Float32Array(3 * triangle.length), told = new Float32Array(triangle.length);
    triangle.forEach((n, k) => {
      place.set(point.subarray(3 * n, 3 * n + 3), 3 * k);
      const one = amount[Math.floor(k / 3)];
      told[k] = Number.isFinite(one) ? one : -1e30;
    });
    loaded = triangle.length;
    const edges = border(triangle);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers.place);
    const lines = new Float32Array(3 * edges.length);
    edges.forEach((n, k) => lines.set(point.subarray(3 * n, 3 * n + 3), 3 * k));
    gl.bufferData(gl.ARRAY_BUFFER, 4 * (place.length + lines.length), gl.STATIC_DRAW);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, place);
    gl.bufferSubData(gl.ARRAY_BUFFER, 4 * place.length, lines);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers.amount);
    gl.bufferData(gl.ARRAY_BUFFER, 4 * (told.length + edges.length), gl.STATIC_DRAW);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, told);
    outlined = edges.length;
    output.textContent = title;
    const [low, high] = content.limits[field.value];
    stage.querySelector(".low").textContent = `${low.toPrecision(3)} mm`;
    stage.querySelector(".high").textContent = `${high.toPrecision(3)} mm`;
    draw();
  }

  const scale = () => { // from mm to the -1..1 of the picture
    const s = near / size, { width, height } = canvas;
    return width > height ? [(s * height) / width, s] : [s, (s * width) / height];
  };

  function draw() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0.933, 0.945, 0.957, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix3fv(at("eye"), true, eye.flat());
    gl.uniform2fv(at("scale"), scale());
    gl.uniform2fv(at("shift"), shift);
    gl.uniform1f(at("depth"), 0.5 / size);
    gl.uniform2fv(at("limits"), content.limits[field.value]);
    gl.uniform1i(at("line"), 0);
    gl.drawArrays(gl.TRIANGLES, 0, loaded);
    gl.uniform1i(at("line"), 1);
    gl.drawArrays(gl.LINES, loaded, outlined);
  }

  // ---- the value under the pointer: the nearest triangle that the line of sight meets
  function read(event) {
    const box = canvas.getBoundingClientRect(), s = scale();
    const x = ((2 * (event.clientX - box.left)) / box.width - 1 - shift[0]) / s[0];
    const y = (1 - (2 * (event.clientY - box.top)) / box.height - shift[1]) / s[1];
    const { point, triangle } = frame();
    let found = -1, nearest = -Infinity;
    for (let t = 0; t < triangle.length; t += 3) {
      const [a, b, c] = corners(point, triangle, t).map((p) => [dot(eye[0], p), dot(eye[1], p), dot(eye[2], p)]);
      const twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
      const v = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / twice;
      const w = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / twice;
      const z = a[2] + v * (b[2] - a[2]) + w * (c[2] - a[2]);
      if (v >= 0 && w >= 0 && v + w <= 1 && z > nearest) { nearest = z; found = t / 3; }
    }
    if (found < 0) { value.textContent = ""; return; }
    const say = (x) => (Number.isFinite(x) ? `${x.toPrecision(4)} mm` : "not measured");
    value.textContent = `${say(frame().thickness[found])} left, ${say(frame().depth[found])} worn off`;
  }

  // ---- hands: one pointer turns, two pinch
  const pointers = new Map();
  const apart = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
  const nearer = (factor) => { near = Math.min(Math.max(near * factor, 0.4), 40); draw(); };
  canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, [event.clientX, event.clientY]); });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) { read(event); return; }
    const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
    const distance = pointers.size === 2 ? apart() : 0;
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (pointers.size === 2) {
      shift = [shift[0] + dx / canvas.clientWidth, shift[1] - dy / canvas.clientHeight];
      nearer(apart() / (distance || 1));
    } else if (event.shiftKey) {
      shift = [shift[0] + (2 * dx) / canvas.clientWidth, shift[1] - (2 * dy) / canvas.clientHeight];
      draw();
    } else turn(0.008 * dx, -0.008 * dy);
  });
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (event) => pointers.delete(event.pointerId));
  canvas.addEventListener("pointerleave", () => { value.textContent = ""; });
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); nearer(Math.exp(-0.0015 * event.deltaY)); }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
    if (step) { event.preventDefault(); turn(...step); } else if (event.key === "+") nearer(1.1); else if (event.key === "-") nearer(1 / 1.1);
  });
  slider.addEventListener("input", load);
  field.addEventListener("change", load);
  stage.querySelector("button").addEventListener("click", () => { eye = front(); near = fit(); shift = [0, 0]; draw(); });
  window.addEventListener("resize", draw);

  const bar = stage.querySelector(".legend canvas"), ink = bar.getContext("2d"), rows = ink.createImageData(1, 256);
  for (let n = 0; n < 256; n++) rows.data.set([...colours.subarray(3 * (255 - n), 3 * (255 - n) + 3), 255], 4 * n);
  ink.putImageData(rows, 0, 0);

  stage.hidden = false;
  document.querySelector("#view .no-view").hidden = true;
  near = fit();
  load();
  stage.dataset.ready = "yes";
})();
