// The moving scene of report.html. Everything comes from the page itself: plotly.js, which draws, lies
// compressed in one inert element, the data in another; both are read once the page has been painted.
"use strict";
(() => {
  const FRAMES = 100;
  const $ = (id) => document.getElementById(id);
  const box = $("scene-box");
  const data = JSON.parse($("scene-data").textContent);
  const LIGHT = { ambient: 0.62, diffuse: 0.6, specular: 0.08, roughness: 0.9, fresnel: 0.05 };
  const INK = "#1a202c";

  // ---- from data to points --------------------------------------------------------------------

  /** Points of a track (see `Track` in result.json) at each moment, m: [moment][3 point + axis]. */
  function unpack(track, moments) {
    const axes = track.split(";").slice(0, -1).map((text) => text.split(" ").map(Number));
    const sums = axes.map(() => 0);
    return Array.from({ length: moments }, (_, k) =>
      Float32Array.from(axes, (changes, i) => (sums[i] += changes[k] || 0) / 1000));
  }

  /** Points between two moments; none after the last moment of a repetition that lost the path. */
  function between(points, at) {
    const k = Math.floor(at);
    if (k + 1 >= points.length) return at <= points.length - 1 ? points[k] : null;
    const share = at - k;
    return points[k].map((v, i) => v + share * (points[k + 1][i] - v));
  }

  const cross = (a, b) =>
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (v) => { const n = Math.hypot(...v) || 1; return v.map((c) => c / n); };

  /** Share of its radius by which a limb swells below its upper joint. */
  const SWELL = { shank: 0.2, forearm: 0.12, thigh: 0.05, "upper-arm": 0.08 };
  /** How far an end stands out, over its radius; a shirt ends in an edge. */
  const STANDS_OUT = { trunk: 0.05, pelvis: 0.5 };
  const kinds = data.segments.map((s) => s.kind);

  /** Capsules as rows of cross-sections; those that go on in each other, as in a trunk, are one row. */
  function chained(capsules) {
    const chains = [];
    for (const { ends, radii_mm, wide, kind } of capsules) {
      const [from, to] = [0, 1].map((e) => ({ point: ends[e], toward: wide && wide.toward[e],
        radii: [(wide || { radii_mm }).radii_mm[e] / 1000, radii_mm[e] / 1000] }));
      const before = chains[chains.length - 1];
      if (wide && before && before.kind === kind && before.sections[before.sections.length - 1].point === from.point) {
        before.sections.push(to);
      } else {
        chains.push({ kind, sections: [from, to] });
      }
    }
    return chains;
  }

  /** A mesh of tapered capsules, `sides` around, `rings` from equator to pole at both ends and `between`
      them; its shape never changes. */
  function tubes(capsules, copies, sides, rings, between = 0) {
    const arc = Array.from({ length: rings }, (_, r) => (r / Math.max(rings - 1, 1)) * (Math.PI / 2));
    const chains = chained(capsules).map((chain) => {
      const last = chain.sections.length - 1;
      const steps = last * (between + 1) - 1;
      // Of each level: where it is among the sections, how far beyond its end, how wide.
      const levels = [
        ...arc.map((angle) => [0, -Math.cos(angle), Math.sin(angle)]),
        ...Array.from({ length: steps }, (_, m) => [(m + 1) / (between + 1), 0, 1]),
        ...arc.map((angle) => [last, Math.cos(angle), Math.sin(angle)]).reverse(),
      ];
      return { ...chain, levels };
    });
    const [i, j, k, of] = [[], [], [], []];
    for (let copy = 0; copy < copies; copy++) {
      for (const { levels, kind } of chains) {
        for (let level = 0; level < levels.length; level++) {
          for (let side = 0; side < sides; side++) {
            const a = of.length;
            of.push((kinds.indexOf(kind) + 0.5) / kinds.length);
            if (level + 1 === levels.length) continue;
            const b = side + 1 < sides ? a + 1 : a + 1 - sides;
            i.push(a, b); j.push(b, b + sides); k.push(a + sides, a + sides);
          }
        }
      }
    }
    const count = of.length;
    const mesh = { x: new Float32Array(count), y: new Float32Array(count), z: new Float32Array(count) };
    const turns = Array.from({ length: sides }, (_, s) =>
      [Math.cos((2 * Math.PI * s) / sides), Math.sin((2 * Math.PI * s) / sides)]);
    const less = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    const mixed = (a, b, t) => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])];
    /** A direction, made square to an axis. */
    const square = (v, axis) => {
      const on = v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2];
      return unit(less(v, axis.map((c) => on * c)));
    };

    function placeChain({ kind, sections, levels }, points, from) {
      const at = (p) => points.subarray(3 * p, 3 * p + 3);
      const last = sections.length - 1;
      const frames = sections.map(({ point, toward }, s) => {
        const axis = unit(less(at(sections[Math.min(s + 1, last)].point), at(sections[Math.max(s - 1, 0)].point)));
        const aside = toward === undefined ? cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]) : less(at(toward), at(point));
        return { middle: at(point), axis, u: square(aside, axis) };
      });
      const swell = 6.75 * (SWELL[kind] || 0);
      const out = STANDS_OUT[kind] || 1;
      let n = from;
      for (const [where, beyond, part] of levels) {
        const s = Math.min(Math.floor(where), last - 1);
        const t = where - s;
        const [a, b] = [frames[s], frames[s + 1]];
        const axis = unit(mixed(a.axis, b.axis, t));
        const u = square(mixed(a.u, b.u, t), axis);
        const v = cross(axis, u);
        const [ra, rb] = [sections[s].radii, sections[s + 1].radii];
        const more = 1 + swell * t * (1 - t) ** 2;
        const [ru, rv] = [0, 1].map((x) => more * (ra[x] + t * (rb[x] - ra[x])));
        const on = beyond * out * Math.min(ru, rv);
        const c = mixed(a.middle, b.middle, t);
        for (const [cos, sin] of turns) {
          // A sole is flat.
          const pu = part * ru * (kind === "foot" ? Math.max(cos, 0) : cos);
          const pv = part * rv * sin;
          mesh.x[n] = c[0] + axis[0] * on + pu * u[0] + pv * v[0];
          mesh.y[n] = c[1] + axis[1] * on + pu * u[1] + pv * v[1];
          mesh.z[n] = c[2] + axis[2] * on + pu * u[2] + pv * v[2];
          n++;
        }
      }
      return n;
    }

    /** Puts copy `copy` where its points are; without points it shrinks to nothing. */
    function place(copy, points) {
      const perCopy = count / copies;
      if (!points) {
        for (const axis of Object.values(mesh)) axis.fill(0, copy * perCopy, (copy + 1) * perCopy);
        return;
      }
      chains.reduce((n, chain) => placeChain(chain, points, n), copy * perCopy);
    }
    return { mesh, i, j, k, place, kinds: Float32Array.from(of) };
  }

  // ---- what stands still ----------------------------------------------------------------------

  /** A point turned by a quaternion and moved. */
  function posed(p, [w, x, y, z], center) {
    const t = cross([x, y, z], p).map((c) => 2 * c);
    const s = cross([x, y, z], t);
    return p.map((c, i) => c + w * t[i] + s[i] + center[i]);
  }

  const CORNERS = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]];
  const EDGES = [[0, 1, 2, 3, 0, 4, 5, 6, 7, 4], [1, 5], [2, 6], [3, 7]];
  const FACES = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4],
    [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]];

  /** Edges at which the triangles of a mesh fold. */
  function creases(points, faces) {
    const beside = new Map();
    const edges = [];
    for (const face of faces) {
      const [a, b, c] = face.map((v) => points[v]);
      const normal = unit(cross([0, 1, 2].map((i) => b[i] - a[i]), [0, 1, 2].map((i) => c[i] - a[i])));
      face.forEach((v, n) => {
        const w = face[(n + 1) % 3];
        const key = v < w ? `${v},${w}` : `${w},${v}`;
        const other = beside.get(key);
        if (!other) beside.set(key, normal);
        else if (Math.abs(other[0] * normal[0] + other[1] * normal[1] + other[2] * normal[2]) < 0.8) edges.push([v, w]);
      });
    }
    return edges;
  }

  /** Points and triangles of an obstacle. */
  function solid(o) {
    if (o.shape === "mesh") {
      const points = o.points_mm.map((p) => p.map((v) => v / 1000));
      return { points, faces: o.triangles, edges: creases(points, o.triangles) };
    }
    if (o.shape === "box") {
      const half = o.size_m.map((s) => s / 2);
      const points = CORNERS.map((c) => posed(c.map((s, i) => s * half[i]), o.quaternion_wxyz, o.center_m));
      return { points, faces: FACES, edges: EDGES };
    }
    if (o.shape === "cylinder") {
      const n = 32;
      const ring = (h) => Array.from({ length: n }, (_, s) => posed([o.radius_m * Math.cos((2 * Math.PI * s) / n),
        o.radius_m * Math.sin((2 * Math.PI * s) / n), h], o.quaternion_wxyz, o.center_m));
      const points = [...ring(-o.length_m / 2), ...ring(o.length_m / 2)];
      const faces = [];
      for (let s = 0; s < n; s++) {
        const t = (s + 1) % n;
        faces.push([s, t, n + s], [t, n + t, n + s]);
        if (s > 0 && s + 1 < n) faces.push([0, t, s], [n, n + s, n + t]);
      }
      const loop = (from) => [...Array(n).keys(), 0].map((s) => from + s);
      return { points, faces, edges: [loop(0), loop(n)] };
    }
    const [a, b] = o.shape === "sphere" ? [o.center_m, o.center_m] : o.ends_m;
    const ball = tubes([{ ends: [0, 1], radii_mm: [1000 * o.radius_m, 1000 * o.radius_m] }], 1, 24, 8);
    ball.place(0, Float32Array.from([...a, ...b]));
    return {
      points: Array.from(ball.mesh.x, (x, n) => [x, ball.mesh.y[n], ball.mesh.z[n]]),
      faces: ball.i.map((v, n) => [v, ball.j[n], ball.k[n]]), edges: [],
    };
  }

  const columns = (points) => ({ x: points.map((p) => p && p[0]), y: points.map((p) => p && p[1]), z: points.map((p) => p && p[2]) });
  const line = (points, name, color, width, dash) => ({
    type: "scatter3d", mode: "lines", ...columns(points), name, hoverinfo: "skip",
    connectgaps: false, line: { color, width, dash: dash || "solid" },
  });
  const words = (points, text, color, size) => ({
    type: "scatter3d", mode: "text", ...columns(points), text, hoverinfo: "skip",
    textposition: "top center", textfont: { color, size: size || 14 },
  });

  function cell(limits) {
    const traces = [];
    const all = { points: [], faces: [], edges: [] };
    const names = [];
    for (const o of data.obstacles) {
      const { points, faces, edges } = solid(o);
      const from = all.points.length;
      for (const p of points) all.points.push(p);
      for (const f of faces) all.faces.push(f.map((v) => v + from));
      for (const edge of edges) all.edges.push(...edge.map((v) => points[v]), null);
      const middle = [0, 1].map((a) => points.reduce((s, p) => s + p[a], 0) / points.length);
      names.push([...middle, Math.max(...points.map((p) => p[2]))]);
    }
    if (all.points.length) {
      const [i, j, k] = [0, 1, 2].map((c) => all.faces.map((f) => f[c]));
      traces.push({ type: "mesh3d", ...columns(all.points), i, j, k, color: "#8d97a6", opacity: 0.45,
        flatshading: true, lighting: LIGHT, hoverinfo: "skip", name: "obstacles" });
      traces.push(line(all.edges, "", "#545e6e", 2));
      traces.push(words(names, data.obstacles.map((o) => o.name), "#3b4453", 13));
    }
    if (data.workspace_m) {
      const [low, high] = data.workspace_m;
      const corner = (c) => c.map((s, a) => (s < 0 ? low[a] : high[a]));
      const edges = EDGES.flatMap((e) => [...e.map((v) => corner(CORNERS[v])), null]);
      traces.push({ ...line(edges, "workspace of the tool", "#005a8c", 2, "dot") });
    }
    // A bar of 1 m and the world's axes on the floor, in a corner.
    const [x, y, z] = [limits[0][0] + 0.1, limits[1][0] + 0.1, limits[2][0] + 0.005];
    const tip = 0.25;
    traces.push(line([[x, y, z], [x + tip, y, z], null, [x, y, z], [x, y + tip, z], null, [x, y, z], [x, y, z + tip]], "", INK, 5));
    traces.push(words([[x + tip, y, z], [x, y + tip, z], [x, y, z + tip]], ["x", "y", "z"], INK, 16));
    const far = limits[1][1] - 0.1;
    traces.push(line([[x - 0.06, far - 1, z], [x - 0.06, far, z]], "", INK, 8));
    traces.push(words([[x - 0.06, far - 0.5, z]], ["1 m"], INK, 16));
    return traces;
  }

  // ---- the plot -------------------------------------------------------------------------------

  const motionOf = (c) => data.motions[c];
  const state = { path: 0, body: data.body, frame: 0, playing: false, ghosts: true };

  function unpacked(motion) {
    if (!motion.ready) {
      const count = motion.samples.length;
      motion.ready = {
        robot: motion.robot && unpack(motion.robot.track, count),
        people: motion.people.map((p) => ({
          typical: p.typical && unpack(p.typical.track, p.typical.rula.length),
          ghosts: p.ghosts.map((g) => unpack(g.track, g.rula.length)),
        })),
      };
    }
    return motion.ready;
  }

  /** Lowest and highest coordinate of everything that is shown, with some room; the floor is in it. */
  function extent() {
    const limits = [0, 1, 2].map(() => [Infinity, -Infinity]);
    const meet = (p) => limits.forEach((l, a) => { l[0] = Math.min(l[0], p[a]); l[1] = Math.max(l[1], p[a]); });
    for (const motion of data.motions) {
      const ready = unpacked(motion);
      const sets = [ready.robot, ...ready.people.flatMap((p) => [p.typical, ...p.ghosts])];
      for (const points of sets) {
        for (const k of points && points.length ? [0, points.length - 1] : []) {
          for (let n = 0; n < points[k].length; n += 3) meet(points[k].subarray(n, n + 3));
        }
      }
    }
    if (data.workspace_m) data.workspace_m.forEach(meet);
    meet([limits[0][0], limits[1][0], 0]);
    return limits.map(([low, high], a) => [a === 2 ? Math.min(low, 0) : low - 0.25, high + 0.25]);
  }

  const mesh = (tube, name, look, opacity) => ({
    type: "mesh3d", ...tube.mesh, i: tube.i, j: tube.j, k: tube.k, name, ...look, opacity, lighting: LIGHT,
    lightposition: { x: 2000, y: -4000, z: 9000 }, hoverinfo: "skip",
  });

  /** A scale with one step for each kind of segment; those without a colour of their own have `score`. */
  const clothed = (score) => ({
    colorscale: data.segments.flatMap((s, n) => [n, n + 1].map((e) => [e / kinds.length, s.color || score])),
  });

  /** Capsules in which ghosts differ from the person shown; a little thinner, so that equal ones hide inside. */
  function varied(capsules, { typical, ghosts }) {
    const differs = (point) => ghosts.some((g) => [0, g.length - 1].some((k) => typical && typical[k] &&
      [0, 1, 2].some((a) => Math.abs(g[k][3 * point + a] - typical[k][3 * point + a]) > 0.002)));
    const thinner = (radii) => radii.map((r) => 0.93 * r);
    return capsules.filter((c) => c.ends.some(differs)).map((c) =>
      ({ ...c, radii_mm: thinner(c.radii_mm), wide: c.wide && { ...c.wide, radii_mm: thinner(c.wide.radii_mm) } }));
  }

  /** Shown things of the chosen path and body. */
  let show = {};
  function choose() {
    const motion = motionOf(state.path);
    const which = motion.people.findIndex((p) => p.body === state.body);
    const people = motion.people[which];
    const ready = unpacked(motion);
    show = {
      motion, people, points: ready.people[which], robotPoints: ready.robot,
      person: people.typical && tubes(people.capsules, 1, 18, 5, 2),
      ghosts: people.ghosts.length && tubes(varied(people.capsules, ready.people[which]), people.ghosts.length, 6, 2),
      robot: motion.robot && tubes(motion.robot.capsules, 1, 12, 3),
    };
  }

  const moment = () => (state.frame / (FRAMES - 1)) * (show.motion.samples.length - 1);
  const level = (rula) => data.levels.find((l) => rula <= l.to) || data.levels[data.levels.length - 1];

  function posture() {
    const at = moment();
    if (show.person) show.person.place(0, between(show.points.typical, at));
    if (show.ghosts) show.points.ghosts.forEach((g, n) => show.ghosts.place(n, between(g, at)));
    if (show.robot) show.robot.place(0, between(show.robotPoints, at));
    const scores = show.people.typical ? show.people.typical.rula : [];
    return level(scores[Math.min(Math.round(at), scores.length - 1)] || 0).color;
  }

  function moving() {
    const score = posture();
    const shown = [
      [show.ghosts, "other repetitions (ghosts)", { color: "#4b5c78", visible: state.ghosts }, 0.13],
      [show.person, "typical repetition", show.person && { ...clothed(score), intensity: show.person.kinds,
        cmin: 0, cmax: 1, showscale: false }, 1],
      [show.robot, "robot", { color: "#c3cad5" }, 1],
    ].filter(([tube]) => tube);
    show.meshes = shown.map(([tube]) => tube.mesh);
    show.personAt = shown.findIndex(([tube]) => tube === show.person);
    return shown.map((args) => mesh(...args));
  }

  function paths() {
    const traces = data.motions.map((motion, n) => {
      const points = [];
      for (let i = 0; i < motion.tcp_mm.length; i += 3) points.push([0, 1, 2].map((a) => motion.tcp_mm[i + a] / 1000));
      const chosen = n === state.path;
      return { ...line(points, motion.name, motion.color, chosen ? 9 : 4, motion.dash), opacity: chosen ? 1 : 0.75 };
    });
    const at = (n) => motionOf(state.path).tcp_mm.slice(n, n === 0 ? 3 : undefined).map((v) => v / 1000);
    const ends = [at(0), at(-3)];
    traces.push({ ...words(ends, ["start", "goal"], INK, 15), mode: "markers+text",
      marker: { size: 6, color: ["#e69f00", "#d55e00"], symbol: ["circle", "square"], line: { color: INK, width: 1 } } });
    return traces;
  }

  // Where the eye is, as seen by the worker: beside, before, above; in units of the scene's cube.
  const [fx, fy] = data.facing;
  const UP = { x: 0, y: 0, z: 1 };
  const EYES = {
    free: { eye: { x: 0.93 * fx + 1.2 * fy, y: 0.93 * fy - 1.2 * fx, z: 0.6 }, up: UP },
    side: { eye: { x: 1.6 * fy, y: -1.6 * fx, z: 0.05 }, up: UP },
    front: { eye: { x: 1.6 * fx, y: 1.6 * fy, z: 0.05 }, up: UP },
    top: { eye: { x: -0.001 * fx, y: -0.001 * fy, z: 1.7 }, up: UP },
  };
  const camera = (view) => ({ center: { x: 0, y: 0, z: -0.06 }, ...EYES[view] });

  let limits;
  function layout() {
    const axis = (a, title) => ({ title: { text: title }, range: limits[a], autorange: false, gridcolor: "#d5dae2", zeroline: false,
      color: "#3b4453", backgroundcolor: "#f3f5f8", showbackground: a === 2, showspikes: false, dtick: 0.5, tickfont: { size: 12 } });
    const size = limits.map(([low, high]) => high - low);
    const longest = Math.max(...size);
    const ratio = size.map((s) => (1.35 * s) / longest);
    return {
      autosize: true, showlegend: false, margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: "keep", paper_bgcolor: "#ffffff",
      font: { family: "system-ui, sans-serif", size: 13, color: INK }, hovermode: false,
      scene: { domain: { x: [0, 1], y: [0, 1] }, hovermode: false, dragmode: "turntable", camera: camera("free"),
        aspectmode: "manual", aspectratio: { x: ratio[0], y: ratio[1], z: ratio[2] },
        xaxis: axis(0, "x (m)"), yaxis: axis(1, "y (m)"), zaxis: axis(2, "height z (m)") },
    };
  }

  function redrawAll() {
    choose();
    const traces = moving();
    const kept = $("scene-plot").layout;
    return Plotly.react("scene-plot", [...traces, ...paths(), ...cell(limits)], kept || layout(),
      { displayModeBar: false, displaylogo: false, responsive: true, plotGlPixelRatio: Math.min(devicePixelRatio || 1, 2) });
  }

  /** Draws the moment. `Plotly.restyle` would make every line and word anew, at three times the cost, so the
      meshes that move are handed to the plot's own objects where these are as known. */
  function draw() {
    const look = clothed(posture());
    readout();
    const plot = $("scene-plot");
    const inner = plot._fullLayout.scene._scene;
    const drawn = show.meshes.map((_, n) => inner?.traces?.[plot._fullData[n]?.uid]);
    if (!drawn.every((d) => d?.update) || !inner.glplot?.redraw) {
      const of = (axis) => show.meshes.map((m) => m[axis].slice());
      const moved = Plotly.restyle(plot, { x: of("x"), y: of("y"), z: of("z") }, show.meshes.map((_, n) => n));
      return show.person ? moved.then(() => Plotly.restyle(plot, { colorscale: [look.colorscale] }, [show.personAt])) : moved;
    }
    show.meshes.forEach((mesh, n) => {
      const now = n === show.personAt ? { ...mesh, ...look } : mesh;
      Object.assign(plot.data[n], now);
      drawn[n].update(Object.assign(plot._fullData[n], now));
    });
    inner.glplot.redraw();
    return Promise.resolve();
  }

  // ---- words and controls ---------------------------------------------------------------------

  // Half a hundredth goes to the even digit, as in every other text of ergopath.
  const fixed = (v) =>
    Number.isFinite(v) ? ((v * 8) % 4 === 1 ? v - 1e-9 : v).toFixed(2) : "unknown";
  function readout() {
    const { motion, people } = show;
    const k = Math.round(moment());
    const time = motion.time_s[k];
    const scores = motion.scores.find((s) => s.body === state.body);
    const own = people.typical && k < people.typical.rula.length ? people.typical : null;
    $("scene-time").textContent = `${time.toFixed(2)} s of ${motion.time_s[motion.time_s.length - 1].toFixed(2)} s`;
    $("scene-own").textContent = own
      ? `RULA ${own.rula[k]} (action level ${level(own.rula[k]).number}: ${level(own.rula[k]).words}), REBA ${own.reba[k]}`
      : "out of reach";
    for (const name of ["rula", "reba"]) {
      const band = scores && scores[name];
      $(`scene-${name}`).textContent = band ? `${fixed(band.mean[k])} (90 % band ${fixed(band.p05[k])} to ${fixed(band.p95[k])})` : "unknown";
    }
    $("scene-frame").setAttribute("aria-valuetext", `${time.toFixed(2)} seconds`);
    $("scene-swatch").style.background = own ? level(own.rula[k]).color : "#ffffff";
  }

  function setPlaying(on) {
    state.playing = on;
    $("scene-play").textContent = on ? "Pause" : "Play";
    $("scene-readout").setAttribute("aria-live", on ? "off" : "polite");
    if (!on) return;
    if (state.frame >= FRAMES - 1) state.frame = 0;
    const first = state.frame;
    let started = null;
    const span = show.motion.time_s[show.motion.time_s.length - 1] * 1000;
    const step = async (now) => {
      if (!state.playing) return;
      started = started ?? now;
      state.frame = Math.min(FRAMES - 1, first + ((now - started) / span) * (FRAMES - 1));
      $("scene-frame").value = Math.round(state.frame);
      await draw();
      box.dataset.frames = Number(box.dataset.frames || 0) + 1;
      if (state.frame >= FRAMES - 1) setPlaying(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  function turn(event) {
    const now = $("scene-plot")._fullLayout.scene.camera;
    const { x, y, z } = now.eye;
    const far = Math.hypot(x, y, z);
    const [around, up] = [Math.atan2(y, x), Math.asin(z / far)];
    const moves = { ArrowLeft: [-0.15, 0, 1], ArrowRight: [0.15, 0, 1], ArrowUp: [0, 0.12, 1], ArrowDown: [0, -0.12, 1],
      "+": [0, 0, 1 / 1.12], "=": [0, 0, 1 / 1.12], "-": [0, 0, 1.12] };
    const move = moves[event.key];
    if (!move) return;
    event.preventDefault();
    const [a, e, r] = [around + move[0], Math.max(-1.5, Math.min(1.5, up + move[1])), far * move[2]];
    const eye = { x: r * Math.cos(e) * Math.cos(a), y: r * Math.cos(e) * Math.sin(a), z: r * Math.sin(e) };
    Plotly.relayout("scene-plot", { "scene.camera": { ...now, eye, up: UP } });
  }

  function controls() {
    $("scene-path").onchange = (e) => { setPlaying(false); state.path = Number(e.target.value); redrawAll().then(draw); };
    $("scene-body").onchange = (e) => { setPlaying(false); state.body = e.target.value; redrawAll().then(draw); };
    $("scene-ghosts").onchange = (e) => { state.ghosts = e.target.checked; if (show.ghosts) Plotly.restyle("scene-plot", { visible: state.ghosts }, [0]).then(draw); };
    $("scene-frame").oninput = (e) => { setPlaying(false); state.frame = Number(e.target.value); draw(); };
    $("scene-play").onclick = () => setPlaying(!state.playing);
    for (const button of box.querySelectorAll("[data-view]")) {
      button.onclick = () => Plotly.relayout("scene-plot", { "scene.camera": camera(button.dataset.view) });
    }
    $("scene-plot").addEventListener("keydown", turn);
  }

  const hasWebGl = () => { const c = document.createElement("canvas"); return !!(c.getContext("webgl2") || c.getContext("webgl")); };

  async function start() {
    if (!hasWebGl()) {
      $("scene-status").textContent = "This browser shows no 3-D graphics (WebGL is off). The figures below show start and goal.";
      return;
    }
    const packed = Uint8Array.from(atob($("scene-library").textContent), (c) => c.charCodeAt(0));
    const library = document.createElement("script");
    library.textContent = await new Response(
      new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
    document.head.append(library);
    box.hidden = false;
    limits = extent();
    await redrawAll();
    controls();
    readout();
    $("scene-status").hidden = true;
    box.dataset.ready = Math.round(performance.now());
  }
  const failed = (error) => {
    $("scene-status").textContent = `The scene could not be made (${error.message}). The figures below show start and goal.`;
    box.hidden = true;
    console.error(error);
  };
  // After the first paint, so that the page can be read at once.
  requestAnimationFrame(() => setTimeout(() => start().catch(failed), 0));
})();
