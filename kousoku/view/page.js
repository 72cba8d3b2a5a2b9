// Draws a scene that moves. What it draws stands as JSON in the element "scene": meshes in units of
// their own, bodies made of them, joints, paths, forces, and the motion in frames of equal times.
"use strict";

(() => {
  const find = (id) => document.getElementById(id);
  const scene = JSON.parse(find("scene").textContent);
  const canvas = find("picture");
  const context = canvas.getContext("2d");
  const slider = find("slider");

  // ---- what is drawn, unpacked ----------------------------------------------------------------

  const SHADES = 32;
  const [start, step, frames] = scene.time;
  const end = start + step * (frames - 1);
  const bodies = scene.bodies; // the first is the ground
  const moving = bodies.length - 1;

  /** 16-bit integers, low byte first, in base 64. */
  function integers(text) {
    const bytes = atob(text);
    const found = new Int16Array(bytes.length / 2);
    for (let k = 0; k < found.length; k++) {
      const value = bytes.charCodeAt(2 * k) | (bytes.charCodeAt(2 * k + 1) << 8);
      found[k] = value > 32767 ? value - 65536 : value;
    }
    return found;
  }

  const motion = integers(scene.motion); // of each frame, of each body: place (3), turn (4)
  const forces = integers(scene.forces); // of each frame, of each force: (3)

  const forceOf = (row, n) =>
    [0, 1, 2].map((c) => forces[3 * (row * scene.loads.length + n) + c] * scene.force.quantum);

  /** Vertices of all parts in the frames of their bodies; faces with normals, colours, edges. */
  function unpack() {
    const vertices = [];
    const faces = [];
    bodies.forEach((body, owner) => {
      body.from = vertices.length / 3;
      for (const [name, color, m] of body.parts) {
        const mesh = scene.meshes[name];
        const first = vertices.length / 3;
        for (let k = 0; k < mesh.v.length; k += 3) {
          const [x, y, z] = mesh.v.slice(k, k + 3);
          for (let row = 0; row < 12; row += 4) {
            vertices.push(m[row] * x + m[row + 1] * y + m[row + 2] * z + m[row + 3]);
          }
        }
        mesh.f.forEach((corners, k) => {
          const places = corners.map((corner) => corner + first);
          const normal = normalOf(places, vertices);
          const [edges, tone] = mesh.e[k] || [0, 0];
          faces.push({ places, normal, owner, color, edges, tone });
        });
      }
      body.to = vertices.length / 3;
    });
    return [Float64Array.from(vertices), faces];
  }

  function normalOf(places, vertices) {
    const n = [0, 0, 0];
    for (let k = 0; k < places.length; k++) {
      const a = 3 * places[k];
      const b = 3 * places[(k + 1) % places.length];
      for (let i = 0; i < 3; i++) {
        const j = (i + 1) % 3;
        const l = (i + 2) % 3;
        n[i] += (vertices[a + j] - vertices[b + j]) * (vertices[a + l] + vertices[b + l]);
      }
    }
    const size = Math.hypot(...n) || 1;
    return n.map((x) => x / size);
  }

  const [vertices, faces] = unpack();
  const seen = new Float64Array(vertices.length); // right, up, toward the viewer
  const flat = new Float64Array((vertices.length / 3) * 2); // on the screen
  const below = new Float64Array(flat.length); // their shadows, on the screen
  const poses = bodies.map(() => ({ r: [0, 0, 0], a: [1, 0, 0, 0, 1, 0, 0, 0, 1] }));

  // ---- where bodies are -----------------------------------------------------------------------

  function setPoses(time, into) {
    const exact = Math.min(Math.max((time - start) / (step || 1), 0), frames - 1);
    const k = Math.min(Math.floor(exact), Math.max(frames - 2, 0));
    const part = exact - k;
    const next = Math.min(k + 1, frames - 1);
    for (let b = 0; b < moving; b++) {
      const i = 7 * (k * moving + b);
      const j = 7 * (next * moving + b);
      const { r } = into[b + 1];
      let same = 0;
      for (let c = 0; c < 3; c++) {
        const value = motion[i + c] + part * (motion[j + c] - motion[i + c]);
        r[c] = scene.origin[c] + scene.quantum * value;
      }
      for (let c = 3; c < 7; c++) same += motion[i + c] * motion[j + c];
      const other = same < 0 ? -part : part; // p and -p are one orientation
      let size = 0;
      const p = [0, 0, 0, 0];
      for (let c = 0; c < 4; c++) {
        p[c] = (1 - part) * motion[i + 3 + c] + other * motion[j + 3 + c];
        size += p[c] * p[c];
      }
      matrixOf(p, size, into[b + 1].a);
    }
  }

  function matrixOf([w, x, y, z], size, a) {
    const s = 2 / size;
    a[0] = 1 - s * (y * y + z * z);
    a[1] = s * (x * y - w * z);
    a[2] = s * (x * z + w * y);
    a[3] = s * (x * y + w * z);
    a[4] = 1 - s * (x * x + z * z);
    a[5] = s * (y * z - w * x);
    a[6] = s * (x * z - w * y);
    a[7] = s * (y * z + w * x);
    a[8] = 1 - s * (x * x + y * y);
  }

  /** Where a point of a body is in frame O. */
  function placed(body, s, at = poses) {
    const { r, a } = at[body];
    return [0, 1, 2].map((c) => r[c] + dot(a.slice(3 * c, 3 * c + 3), s));
  }

  function turned(body, s) {
    const { a } = poses[body];
    return [0, 1, 2].map((c) => dot(a.slice(3 * c, 3 * c + 3), s));
  }

  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [
    a[1] * b[2] - a[2] * b[1],
    a[2] * b[0] - a[0] * b[2],
    a[0] * b[1] - a[1] * b[0],
  ];
  const unit = (a) => a.map((x) => x / (Math.hypot(...a) || 1));

  // ---- from where it is seen ------------------------------------------------------------------

  const view = {};

  function resetView() {
    Object.assign(view, { azimuth: scene.view[0], elevation: scene.view[1] });
    Object.assign(view, { zoom: 1, shift: [0, 0] });
    fit();
    request();
  }

  /** Right, up and toward the viewer, in frame O. */
  function cameraOf() {
    const { azimuth, elevation } = view;
    const [east, north, up] = scene.directions;
    const level = [0, 1, 2].map((c) => Math.sin(azimuth) * east[c] - Math.cos(azimuth) * north[c]);
    const toward = [0, 1, 2].map((c) => Math.cos(elevation) * level[c] + Math.sin(elevation) * up[c]);
    const right = [0, 1, 2].map((c) => Math.cos(azimuth) * east[c] + Math.sin(azimuth) * north[c]);
    return [right, cross(toward, right), toward];
  }

  /** The corners of what bodies and paths reach, at times over the whole motion. */
  const reached = (() => {
    const corners = bodies.map((body) => {
      const low = [Infinity, Infinity, Infinity];
      const high = [-Infinity, -Infinity, -Infinity];
      for (let k = 3 * body.from; k < 3 * body.to; k++) {
        low[k % 3] = Math.min(low[k % 3], vertices[k]);
        high[k % 3] = Math.max(high[k % 3], vertices[k]);
      }
      const all = [0, 1, 2, 3, 4, 5, 6, 7];
      return body.to > body.from
        ? all.map((n) => [0, 1, 2].map((c) => ((n >> c) & 1 ? high[c] : low[c])))
        : [[0, 0, 0]];
    });
    const found = [];
    const there = bodies.map(() => ({ r: [0, 0, 0], a: [1, 0, 0, 0, 1, 0, 0, 0, 1] }));
    const times = Math.min(frames, Math.max(2, Math.ceil(4000 / bodies.length)), 60);
    for (let k = 0; k < times; k++) {
      setPoses(start + (times > 1 ? (k / (times - 1)) * (end - start) : 0), there);
      corners.forEach((own, body) => {
        if (body > 0 || k === 0) own.forEach((s) => found.push(placed(body, s, there)));
      });
      if (!scene.forcesShown) continue;
      const row = Math.round((k / Math.max(times - 1, 1)) * (frames - 1));
      scene.loads.forEach(({ body, s }, n) => {
        const f = forceOf(row, n);
        const part = Math.min(1, scene.force.largest / (Math.hypot(...f) || 1));
        found.push(placed(body, s, there).map((x, c) => x + part * scene.force.length * f[c]));
      });
    }
    return found;
  })();
  const middle = [0, 1, 2].map((c) => {
    const values = reached.map((point) => point[c]);
    return (Math.min(...values) + Math.max(...values)) / 2;
  });
  const radius = Math.max(...reached.map((p) => Math.hypot(...p.map((x, c) => x - middle[c]))));
  const distance = scene.flat ? Infinity : 4.5 * (radius || 1);

  let scale = 1;
  let center = [0, 0];
  let width = 1;
  let height = 1;

  const nearer = (z) => (distance === Infinity ? 1 : distance / Math.max(distance - z, 0.05 * distance));

  function fit() {
    const camera = cameraOf();
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const point of reached) {
      const d = point.map((x, c) => x - middle[c]);
      const [x, y, z] = camera.map((axis) => dot(axis, d));
      left = Math.min(left, nearer(z) * x);
      right = Math.max(right, nearer(z) * x);
      low = Math.min(low, nearer(z) * y);
      high = Math.max(high, nearer(z) * y);
    }
    const margin = [Math.min(60, 0.08 * width) + 10, Math.min(60, 0.1 * height) + 14];
    const across = Math.max(right - left, 1e-9 * (radius || 1), 1e-300);
    const along = Math.max(high - low, 1e-9 * (radius || 1), 1e-300);
    scale = Math.min((width - 2 * margin[0]) / across, (height - 2 * margin[1]) / along);
    center = [(left + right) / 2, (low + high) / 2];
  }

  function screen(x, y, z) {
    const k = scale * view.zoom;
    return [
      width / 2 + view.shift[0] + k * (nearer(z) * x - center[0]),
      height / 2 + view.shift[1] - k * (nearer(z) * y - center[1]),
    ];
  }

  function projected(point, camera) {
    const d = [point[0] - middle[0], point[1] - middle[1], point[2] - middle[2]];
    const z = dot(camera[2], d);
    const [x, y] = screen(dot(camera[0], d), dot(camera[1], d), z);
    return [x, y, z];
  }

  // ---- colours --------------------------------------------------------------------------------

  let colors = {};
  let palettes = [];

  function readColors() {
    const style = getComputedStyle(document.documentElement);
    for (const name of "back sky ink quiet grid shadow edge axis force".split(" ")) {
      colors[name] = style.getPropertyValue(`--${name}`).trim();
    }
    const isDark = matchMedia("(prefers-color-scheme: dark)").matches;
    palettes = (isDark ? scene.dark : scene.light).map((color) => {
      const rgb = [1, 3, 5].map((k) => parseInt(color.slice(k, k + 2), 16));
      return Array.from({ length: SHADES }, (_, k) => {
        const light = 0.52 + (0.6 * k) / (SHADES - 1);
        const mixed = rgb.map((x) => Math.round(light <= 1 ? x * light : 255 - (255 - x) * (2 - light)));
        return `rgb(${mixed.join(",")})`;
      });
    });
  }

  // ---- one picture ----------------------------------------------------------------------------

  const LIGHT = unit([-0.4, 0.75, 0.65]);
  const order = [];
  const depth = [];
  const lines = []; // [x, y, x, y, colour, width, alpha] with depths beside the faces'

  function addLine(a, b, color, thickness, alpha = 1) {
    order.push(-1 - lines.length);
    lines.push([a[0], a[1], b[0], b[1], color, thickness, alpha, (a[2] + b[2]) / 2]);
  }

  const depthOf = (k) => (k >= 0 ? depth[k] : lines[-1 - k][7]);

  function project(camera) {
    const k = scale * view.zoom;
    const x0 = width / 2 + view.shift[0] - k * center[0];
    const y0 = height / 2 + view.shift[1] + k * center[1];
    bodies.forEach((body, owner) => {
      const { r, a } = poses[owner];
      const d = [r[0] - middle[0], r[1] - middle[1], r[2] - middle[2]];
      const m = [];
      const t = [];
      for (const axis of camera) {
        for (let c = 0; c < 3; c++) m.push(axis[0] * a[c] + axis[1] * a[c + 3] + axis[2] * a[c + 6]);
        t.push(dot(axis, d));
      }
      const about = ([x, y, z]) => [0, 1, 2].map((c) => x * m[c] + y * m[c + 3] + z * m[c + 6]);
      body.lamp = about(LIGHT); // directions in the frame of the body
      body.up = about(camera.map((axis) => dot(axis, floor.normal)));
      for (let v = body.from; v < body.to; v++) {
        const x = vertices[3 * v];
        const y = vertices[3 * v + 1];
        const z = vertices[3 * v + 2];
        const right = m[0] * x + m[1] * y + m[2] * z + t[0];
        const up = m[3] * x + m[4] * y + m[5] * z + t[1];
        const near = m[6] * x + m[7] * y + m[8] * z + t[2];
        const f = k * nearer(near);
        seen[3 * v] = right;
        seen[3 * v + 1] = up;
        seen[3 * v + 2] = near;
        flat[2 * v] = x0 + f * right;
        flat[2 * v + 1] = y0 - f * up;
      }
    });
  }

  function isFacing(places) {
    const a = 2 * places[0];
    const b = 2 * places[1];
    const c = 2 * places[2];
    const p = (flat[b] - flat[a]) * (flat[c + 1] - flat[a + 1]);
    return p - (flat[b + 1] - flat[a + 1]) * (flat[c] - flat[a]) < 0;
  }

  function collectFaces() {
    for (let n = 0; n < faces.length; n++) {
      const { places } = faces[n];
      if (!isFacing(places)) continue;
      let sum = 0;
      for (const v of places) sum += seen[3 * v + 2];
      depth[n] = sum / places.length;
      order.push(n);
    }
  }

  function trace(places, at) {
    context.moveTo(at[2 * places[0]], at[2 * places[0] + 1]);
    for (let k = 1; k < places.length; k++) context.lineTo(at[2 * places[k]], at[2 * places[k] + 1]);
    context.closePath();
  }

  function drawFace({ places, normal, owner, color, edges, tone }) {
    const { lamp } = bodies[owner];
    const light = lamp[0] * normal[0] + lamp[1] * normal[1] + lamp[2] * normal[2];
    const bright = Math.min(1, Math.max(0, 0.12 + 0.88 * light - 0.22 * tone));
    const shade = Math.round((SHADES - 1) * bright);
    const fill = palettes[color][shade];
    context.fillStyle = fill;
    context.strokeStyle = fill;
    context.lineWidth = 0.8;
    context.beginPath();
    trace(places, flat);
    context.fill();
    context.stroke(); // or the background shines through between faces
    if (!edges) return;
    context.strokeStyle = colors.edge;
    context.lineWidth = 0.9;
    context.globalAlpha = 0.7;
    context.beginPath();
    for (let k = 0; k < places.length; k++) {
      if (!((edges >> k) & 1)) continue;
      const a = 2 * places[k];
      const b = 2 * places[(k + 1) % places.length];
      context.moveTo(flat[a], flat[a + 1]);
      context.lineTo(flat[b], flat[b + 1]);
    }
    context.stroke();
    context.globalAlpha = 1;
  }

  function drawLine([x, y, u, v, color, thickness, alpha]) {
    context.strokeStyle = color;
    context.lineWidth = thickness;
    context.globalAlpha = alpha;
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(u, v);
    context.stroke();
    context.globalAlpha = 1;
  }

  // The floor, or behind a planar mechanism the plane: lines at round distances.
  const floor = (() => {
    const normal = scene.flat ? scene.directions[1].map((x) => -x) : scene.directions[2];
    const across = scene.directions[0];
    const along = scene.flat ? scene.directions[2] : scene.directions[1];
    const height = Math.min(...reached.map((point) => dot(normal, point)));
    const rough = (radius || 1) / 4;
    const power = 10 ** Math.floor(Math.log10(rough));
    const size = power * (rough / power >= 5 ? 5 : rough / power >= 2 ? 2 : 1);
    return { normal, across, along, height, size };
  })();

  function drawFloor(camera) {
    const { normal, across, along, height: level, size } = floor;
    const slope = dot(camera[2], normal);
    if (slope < 0.04) return;
    const shown = scene.flat ? Math.hypot(width, height) / (scale * view.zoom) : 1.15 * radius;
    const reach = size * Math.min(Math.ceil(shown / size), 200);
    const at = (u, v) => {
      const point = [0, 1, 2].map((c) => u * across[c] + v * along[c] + level * normal[c]);
      return projected(point, camera);
    };
    const u0 = size * Math.round(dot(middle, across) / size);
    const v0 = size * Math.round(dot(middle, along) / size);
    context.strokeStyle = colors.grid;
    context.lineWidth = 1;
    context.globalAlpha = Math.min(1, 4 * slope);
    context.beginPath();
    for (let d = -reach; d <= reach + size / 2; d += size) {
      for (const [a, b] of [
        [at(u0 + d, v0 - reach), at(u0 + d, v0 + reach)],
        [at(u0 - reach, v0 + d), at(u0 + reach, v0 + d)],
      ]) {
        context.moveTo(a[0], a[1]);
        context.lineTo(b[0], b[1]);
      }
    }
    context.stroke();
    context.globalAlpha = 1;
    if (!scene.flat) drawShadow(camera);
  }

  /** Straight down on the floor: all that faces upward, as one shape. */
  function drawShadow(camera) {
    const up = camera.map((axis) => dot(axis, floor.normal));
    const base = floor.height - dot(floor.normal, middle);
    for (let k = 0; k < seen.length; k += 3) {
      const fall = seen[k] * up[0] + seen[k + 1] * up[1] + seen[k + 2] * up[2] - base;
      const [x, y] = screen(seen[k] - fall * up[0], seen[k + 1] - fall * up[1], seen[k + 2] - fall * up[2]);
      below[(2 * k) / 3] = x;
      below[(2 * k) / 3 + 1] = y;
    }
    context.fillStyle = colors.shadow;
    context.beginPath();
    for (const { places, normal, owner } of faces) {
      if (dot(bodies[owner].up, normal) > 0.02) trace(places, below);
    }
    context.fill();
  }

  // Paths are places in frame O: curves through all frames, with corners too small to be seen. What
  // is straight has few points, and no more lines are drawn than a screen shows in time.
  const [CORNER, PIECES, LEAST, MOST] = [0.12, 4, 240, 6000];
  const tracks = (() => {
    const there = bodies.map(() => ({ r: [0, 0, 0], a: [1, 0, 0, 0, 1, 0, 0, 0, 1] }));
    const times = Array.from({ length: frames }, (_, k) => start + k * step);
    const found = scene.paths.map(() => []);
    for (const time of times) {
      setPoses(time, there);
      scene.paths.forEach(({ body, s }, n) => found[n].push(placed(body, s, there)));
    }
    return found.map((points, n) => curve(points, times, scene.paths[n].color));
  })();

  /** The curve through points: between two of them a cubic, of more pieces where it bends. */
  function curve(points, times, color) {
    const found = { points: [points[0]], times: [times[0]], color };
    const last = points.length - 1;
    const bends = points.map((p, k) => bend(points[Math.max(k - 1, 0)], p, points[Math.min(k + 1, last)]));
    const [few, skipped] = [Math.min(PIECES, Math.floor(LEAST / points.length)), points.length / LEAST];
    let [turn, since] = [0, 0];
    for (let k = 1; k <= last; k++) {
      const [p, q] = [points[k - 1], points[k]];
      const o = k > 1 ? points[k - 2] : ahead(p, q, points[Math.min(2, last)]);
      const r = k < last ? points[k + 1] : ahead(q, p, points[Math.max(last - 2, 0)]);
      const sharp = Math.ceil(Math.max(bends[k - 1], bends[k]) / CORNER);
      const pieces = Math.max(1, few, Math.min(PIECES, sharp));
      turn += bends[k];
      since += 1;
      if (pieces === 1 && turn < CORNER / 2 && since < skipped && k < last) continue;
      [turn, since] = [0, 0];
      for (let piece = 1; piece <= pieces; piece++) {
        const s = piece / pieces;
        const [a, b] = [s * (1 - s) ** 2, s * s * (1 - s)];
        const part = s * s * (3 - 2 * s);
        found.points.push(
          p.map((x, c) => (1 - part) * x + part * q[c] + (a / 2) * (q[c] - o[c]) - (b / 2) * (r[c] - x)),
        );
        found.times.push(times[k - 1] + s * (times[k] - times[k - 1]));
      }
    }
    return found;
  }

  /** The point ahead of p on the parabola through p, q and r. */
  function ahead(p, q, r) {
    return p.map((x, c) => 3 * (x - q[c]) + r[c]);
  }

  /** The angle by which a way from o over p to q turns. */
  function bend(o, p, q) {
    const [u, v] = [p.map((x, c) => x - o[c]), q.map((x, c) => x - p[c])];
    return Math.atan2(Math.hypot(...cross(u, v)), dot(u, v));
  }

  function addPaths(camera) {
    const most = Math.floor(MOST / tracks.length);
    for (const { points, times, color } of tracks) {
      const here = times.findIndex((time) => time > now);
      const middle = here < 0 ? points.length : here;
      const from = Math.max(0, Math.min(middle - Math.floor(most / 2), points.length - most));
      const places = points.slice(from, from + most).map((point) => projected(point, camera));
      const ink = palettes[color][20];
      for (let k = 1; k < places.length; k++) {
        const isPast = times[from + k] <= now;
        addLine(places[k - 1], places[k], ink, isPast ? 2.2 : 1.4, isPast ? 0.9 : 0.35);
      }
    }
  }

  const DASHES = [
    [-1, -0.55],
    [-0.47, -0.39],
    [-0.31, 0],
    [0, 0.31],
    [0.39, 0.47],
    [0.55, 1],
  ];

  function addAxes(camera) {
    for (const [body, s, direction] of scene.axes) {
      const at = placed(body, s);
      const along = turned(body, direction);
      const point = (k) => projected([0, 1, 2].map((c) => at[c] + k * along[c]), camera);
      for (const [a, b] of DASHES) addLine(point(a), point(b), colors.axis, 1.3, 0.9);
    }
  }

  /** Rods without mass, springs, guides: lines between points of two bodies. */
  function addStruts(camera) {
    for (const { kind, i, j, a, b, color, width: thickness } of scene.struts) {
      const from = placed(i, a);
      const to = placed(j, b);
      const at = (part, side = 0, across = [0, 0, 0]) =>
        projected([0, 1, 2].map((c) => from[c] + part * (to[c] - from[c]) + side * across[c]), camera);
      const size = Math.max(1, thickness * scale * view.zoom);
      if (kind === "guide") {
        addLine(at(0), at(1), colors.quiet, 1.2, 0.8);
      } else if (kind === "rod") {
        for (let k = 0; k < 8; k++) addLine(at(k / 8), at((k + 1) / 8), palettes[color][20], size);
      } else {
        const along = unit([0, 1, 2].map((c) => to[c] - from[c]));
        const across = unit(cross(along, camera[2]));
        const turns = 12;
        const knots = [at(0), at(0.12)];
        for (let k = 0; k < turns; k++) {
          const part = 0.12 + (0.76 * (k + 0.5)) / turns;
          knots.push(at(part, (k % 2 ? -2.2 : 2.2) * thickness, across));
        }
        knots.push(at(0.88), at(1));
        for (let k = 1; k < knots.length; k++) addLine(knots[k - 1], knots[k], palettes[color][18], 1.8);
      }
    }
  }

  // ---- what stands above it: arrows, names, the directions ------------------------------------

  function arrow(a, b, color, thickness) {
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    const length = Math.hypot(dx, dy);
    if (length < 2) return;
    const [ux, uy] = [dx / length, dy / length];
    const head = Math.min(11, 0.6 * length);
    context.strokeStyle = color;
    context.fillStyle = color;
    context.lineWidth = thickness;
    context.beginPath();
    context.moveTo(a[0], a[1]);
    context.lineTo(b[0] - 0.8 * head * ux, b[1] - 0.8 * head * uy);
    context.stroke();
    context.beginPath();
    context.moveTo(b[0], b[1]);
    context.lineTo(b[0] - head * ux - 0.4 * head * uy, b[1] - head * uy + 0.4 * head * ux);
    context.lineTo(b[0] - head * ux + 0.4 * head * uy, b[1] - head * uy - 0.4 * head * ux);
    context.fill();
  }

  let taken = [];
  const BESIDE = [
    [12, -10],
    [12, 16],
    [-12, -10],
    [-12, 16],
    [0, -20],
    [0, 26],
  ];

  /** Write a text beside a point where nothing is written yet, or not at all. */
  function write(text, x, y, color) {
    const wide = context.measureText(text).width;
    for (const [dx, dy] of BESIDE) {
      const left = x + dx - (dx < 0 ? wide : dx === 0 ? wide / 2 : 0);
      const box = [left - 3, y + dy - 13, left + wide + 3, y + dy + 5];
      if (box[0] < 0 || box[2] > width || box[1] < 0 || box[3] > height) continue;
      if (taken.some((b) => b[0] < box[2] && box[0] < b[2] && b[1] < box[3] && box[1] < b[3])) continue;
      taken.push(box);
      context.lineWidth = 3.5;
      context.lineJoin = "round";
      context.strokeStyle = colors.back;
      context.strokeText(text, left, y + dy);
      context.fillStyle = color;
      context.fillText(text, left, y + dy);
      return;
    }
  }

  function digits(value) {
    if (value === 0) return "0";
    const size = Math.floor(Math.log10(Math.abs(value)));
    if (size >= 5 || size < -3) return value.toExponential(2);
    return value.toFixed(Math.max(0, 2 - size));
  }

  function drawForces(camera) {
    const exact = Math.min(Math.max((now - start) / (step || 1), 0), frames - 1);
    const row = Math.round(exact);
    const written = [];
    scene.loads.forEach(({ body, s, name }, n) => {
      const f = forceOf(row, n);
      const size = Math.hypot(...f);
      const at = placed(body, s);
      const tip = at.map((x, c) => x + scene.force.length * f[c]);
      const a = projected(at, camera);
      const b = projected(tip, camera);
      arrow(a, b, colors.force, 2.4);
      if (size > 0) written.push([`${name} ${digits(size)} ${scene.force.unit}`, b[0], b[1]]);
    });
    context.font = "12px system-ui, sans-serif";
    for (const [text, x, y] of written) write(text, x, y, colors.force);
  }

  function drawNames(camera) {
    context.font = "600 13px system-ui, sans-serif";
    for (const body of bodies.slice(1)) {
      const [x, y] = projected(placed(bodies.indexOf(body), body.at), camera);
      write(body.name, x, y, palettes[body.color][isDark() ? 31 : 10]);
    }
    context.font = "12px system-ui, sans-serif";
    const loaded = find("forces").checked ? scene.loads.map(({ name }) => name) : [];
    for (const { name, body, s } of scene.joints) {
      if (loaded.includes(name)) continue; // its force says its name
      const [x, y] = projected(placed(body, s), camera);
      write(name, x, y, colors.quiet);
    }
  }

  const isDark = () => matchMedia("(prefers-color-scheme: dark)").matches;

  function drawDirections(camera) {
    const foot = height - document.getElementById("verdict").offsetHeight; // above what is told
    const [x, y] = [46, foot - 46];
    const arms = [0, 1, 2].map((c) => ({ c, to: camera.map((axis) => axis[c]) }));
    arms.sort((a, b) => a.to[2] - b.to[2]);
    context.font = "italic 12px system-ui, sans-serif";
    const inks = isDark() ? ["#ff8a80", "#7fd18c", "#8ab4f8"] : ["#b3261e", "#2e7d32", "#1a56c4"];
    for (const { c, to } of arms) {
      if (Math.hypot(to[0], to[1]) < 0.12) continue;
      arrow([x, y], [x + 30 * to[0], y - 30 * to[1]], inks[c], 1.8);
      context.fillStyle = inks[c];
      context.textAlign = "center";
      context.fillText("xyz"[c], x + 39 * to[0], y - 39 * to[1] + 4);
      context.textAlign = "left";
    }
    context.font = "12px system-ui, sans-serif";
    context.fillStyle = colors.quiet;
    context.fillText(`grid ${Number(floor.size.toPrecision(3))} ${scene.unit}`, x + 48, foot - 12);
  }

  function draw() {
    const camera = cameraOf();
    setPoses(now, poses);
    const back = context.createLinearGradient(0, 0, 0, height);
    back.addColorStop(0, colors.sky);
    back.addColorStop(1, colors.back);
    context.fillStyle = back;
    context.fillRect(0, 0, width, height);
    context.lineJoin = "round";
    context.lineCap = "round";
    order.length = 0;
    lines.length = 0;
    taken = [[0, 0, Math.min(width, find("title").scrollWidth), 30]];
    project(camera);
    drawFloor(camera);
    collectFaces();
    addStruts(camera);
    if (find("axes").checked) addAxes(camera);
    if (find("paths").checked) addPaths(camera);
    order.sort((a, b) => depthOf(a) - depthOf(b));
    for (const k of order) {
      if (k >= 0) drawFace(faces[k]);
      else drawLine(lines[-1 - k]);
    }
    if (find("forces").checked) drawForces(camera);
    if (find("names").checked) drawNames(camera);
    drawDirections(camera);
  }

  // ---- time -----------------------------------------------------------------------------------

  let now = start;
  let isPlaying = false;
  let last = 0;
  let isAsked = false;

  const decimals = Math.max(2, Math.min(9, 3 - Math.floor(Math.log10(end - start || 1))));

  function showTime() {
    slider.value = String(now);
    find("time").textContent = `t = ${now.toFixed(decimals)} s`;
  }

  function request() {
    if (!isAsked) requestAnimationFrame(next);
    isAsked = true;
  }

  function next(stamp) {
    isAsked = false;
    if (isPlaying) {
      now += Math.min((stamp - last) / 1000, 0.25) * speedOf();
      if (now > end) now = end > start ? start + ((now - start) % (end - start)) : start;
      last = stamp;
      request();
    }
    const began = performance.now();
    showTime();
    draw();
    canvas.dataset.milliseconds = (performance.now() - began).toFixed(2);
  }

  function play(wanted) {
    isPlaying = wanted && end > start;
    if (isPlaying && now >= end) now = start;
    last = performance.now();
    find("play").classList.toggle("playing", isPlaying);
    find("play").setAttribute("aria-pressed", String(isPlaying));
    request();
  }

  function go(time) {
    play(false);
    now = Math.min(Math.max(time, start), end);
    request();
  }

  const speeds = find("speed");
  const speedOf = () => Number(speeds.value);

  function fillSpeeds() {
    const known = new Set([scene.speed]);
    for (const factor of [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10]) known.add(factor * scene.speed);
    known.add(1);
    for (const value of [...known].map((x) => Number(x.toPrecision(2))).sort((a, b) => a - b)) {
      speeds.add(new Option(value === 1 ? "real time" : `${value} ×`, String(value)));
    }
    speeds.value = String(Number(scene.speed.toPrecision(2)));
  }

  // ---- what the user does ---------------------------------------------------------------------

  const pointers = new Map();

  function orbit(dx, dy) {
    view.azimuth -= dx / 150;
    view.elevation = Math.min(Math.max(view.elevation + dy / 150, -1.57), 1.57);
  }

  function zoom(factor, x = width / 2, y = height / 2) {
    const before = view.zoom;
    view.zoom = Math.min(Math.max(before * factor, 0.05), 50);
    const change = view.zoom / before;
    const at = [x - width / 2, y - height / 2];
    view.shift = view.shift.map((s, k) => at[k] + change * (s - at[k]));
    request();
  }

  function place(event) {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, place(event));
    canvas.focus({ preventScroll: true });
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const here = place(event);
    const [dx, dy] = [here[0] - before[0], here[1] - before[1]];
    if (pointers.size === 2) {
      const [[, other]] = [...pointers].filter(([id]) => id !== event.pointerId);
      const apart = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
      zoom(apart(here) / apart(before), other[0], other[1]);
      view.shift = [view.shift[0] + dx / 2, view.shift[1] + dy / 2];
    } else if (event.shiftKey || event.buttons & 6) {
      view.shift = [view.shift[0] + dx, view.shift[1] + dy];
    } else {
      orbit(dx, dy);
    }
    pointers.set(event.pointerId, here);
    request();
  });
  for (const kind of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(kind, (event) => pointers.delete(event.pointerId));
  }
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", resetView);
  canvas.addEventListener(
    "wheel",
    (event) => {
      // In a frame of another page the wheel scrolls that page until the picture was clicked.
      if (window.parent !== window && document.activeElement !== canvas) return;
      event.preventDefault();
      zoom(Math.exp(-event.deltaY / 600), ...place(event));
    },
    { passive: false },
  );

  function faster(by) {
    const index = Math.min(Math.max(speeds.selectedIndex + by, 0), speeds.length - 1);
    speeds.selectedIndex = index;
  }

  const KEYS = {
    " ": () => play(!isPlaying),
    ArrowLeft: () => go(now - (end - start) / 100),
    ArrowRight: () => go(now + (end - start) / 100),
    ArrowUp: () => orbit(0, 12),
    ArrowDown: () => orbit(0, -12),
    "+": () => faster(1),
    "-": () => faster(-1),
    Home: () => go(start),
    End: () => go(end),
    0: resetView,
  };

  addEventListener("keydown", (event) => {
    const isChoice = event.target === speeds || event.target.type === "checkbox";
    const isPress = event.target.tagName === "BUTTON" && event.key === " ";
    if (isChoice || isPress || event.ctrlKey || event.metaKey || event.altKey) return;
    const act = KEYS[event.key];
    if (!act) return;
    event.preventDefault();
    act();
    request();
  });

  find("play").addEventListener("click", () => play(!isPlaying));
  find("reset").addEventListener("click", resetView);
  slider.addEventListener("input", () => go(Number(slider.value)));
  for (const id of ["names", "axes", "paths", "forces"]) find(id).addEventListener("change", request);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    readColors();
    request();
  });

  function resize() {
    const box = canvas.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    width = Math.max(box.width, 1);
    height = Math.max(box.height, 1);
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const kept = { ...view };
    Object.assign(view, { azimuth: scene.view[0], elevation: scene.view[1] });
    fit();
    Object.assign(view, kept);
    request();
  }

  // ---- begin ----------------------------------------------------------------------------------

  slider.min = String(start);
  slider.max = String(end);
  find("names").checked = scene.names;
  find("axes").checked = scene.names;
  find("forces").checked = scene.forcesShown;
  find("forces").parentElement.hidden = scene.loads.length === 0;
  find("paths").parentElement.hidden = scene.paths.length === 0;
  find("axes").parentElement.hidden = scene.axes.length === 0;
  fillSpeeds();
  readColors();
  Object.assign(view, { azimuth: scene.view[0], elevation: scene.view[1], zoom: 1, shift: [0, 0] });
  new ResizeObserver(resize).observe(canvas);
  resize();
  const asked = /^#t=([-+.\deE]+)$/.exec(location.hash); // x.html#t=0.5 stands at that time
  if (asked) go(Number(asked[1]));
  else play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
})();
