// SPDX-License-Identifier: LGPL-3.0-or-later
// One mass at a floor: the law of Signorini and Moreau, Coulomb's law, Newton's method on both.
// The first half computes and knows no page (a test runs it by node); the second draws.
"use strict";

const OnePoint = (() => {
  const g = 9.81; // m/s²

  // Newton's method for lam = chi(g_n) g_n, tau = P_b(tau + rho_t w_t), b = mu chi(g_n) max(-g_n, 0).
  // w_n = free_n + W lam - allowed, w_t = free_t - W tau: the velocities with which the step ends.
  // What would slip one way and, in the next iterate, the other way sticks in between: else large
  // rho lead it to and fro for ever.
  function newton({ free_n, free_t, allowed, W, mu, rho, start }) {
    let lam = start, tau = 0, way = 0; // of the slip before
    const iterates = [];
    for (let i = 0; i < 40; i++) {
      const w_n = free_n + W * lam, w_t = free_t - W * tau;
      iterates.push({ w_n, w_t, lam, tau });
      const g_n = lam - rho * (w_n - allowed), chi = g_n <= 0 ? 1 : 0;
      const g_t = tau + rho * w_t, b = mu * chi * Math.max(-g_n, 0);
      const slips = Math.abs(g_t) > b, P = slips ? b * Math.sign(g_t) : g_t;
      const R1 = lam - chi * g_n, R2 = tau - P;
      const size = Math.abs(free_n) + Math.abs(free_t) + 1e-300;
      if (W * (Math.abs(R1) + Math.abs(R2)) < 1e-12 * size) return iterates;
      const dg = 1 - rho * W; // of g_n by lam, of g_t by tau
      const d_lam = -R1 / (1 - chi * dg);
      const by_lam = slips ? mu * chi * dg * Math.sign(g_t) : 0; // of -P by lam
      const turns = slips && Math.sign(g_t) === -way;
      tau += turns ? w_t / W : (-R2 - by_lam * d_lam) / (slips ? 1 : 1 - dg);
      way = slips && !turns ? Math.sign(g_t) : 0;
      lam += d_lam;
    }
    return iterates;
  }

  // A mass thrown from the height h with the speed v_t: rows of t, x, y, v_x, v_y, lam, tau.
  // law "velocity": it may approach as fast as it would arrive, and what starts faster is struck,
  // with restitution e. law "gap": d_n <= 0 at the end of each step.
  function fall({ law, theta, e, mu, dt, m = 1, h = 0.5, v_t = 1, until = 1.5 }) {
    let x = 0, y = h, v_x = v_t, v_y = 0;
    const rows = [{ t: 0, x, y, v_x, v_y, lam: 0, tau: 0 }];
    for (let k = 1; k <= Math.round(until / dt); k++) {
      const d = -y; // the gap, positive inside
      if (law === "velocity" && -v_y > Math.max(-d / dt, 0) + 1e-12) {
        const limit = e > 0 ? e * v_y : -d / dt; // a percussion: no time passes
        const hit = newton({ free_n: -v_y, free_t: v_x, allowed: limit, W: 1 / m, mu, rho: m, start: 0 });
        v_y = -hit.at(-1).w_n;
        v_x = hit.at(-1).w_t;
      }
      const back = (1 - theta) / theta;
      const allowed = law === "gap"
        ? -(d - dt * (1 - theta) * v_y) / (theta * dt)
        : Math.max(-d / dt, back * v_y, 0);
      const W = dt / m;
      const step = newton({ free_n: -(v_y - dt * g), free_t: v_x, allowed, W, mu, rho: 1 / W, start: 0 });
      const { w_n, w_t, lam, tau } = step.at(-1);
      y += dt * ((1 - theta) * v_y - theta * w_n);
      x += dt * ((1 - theta) * v_x + theta * w_t);
      v_y = -w_n;
      v_x = w_t;
      rows.push({ t: k * dt, x, y, v_x, v_y, lam, tau });
    }
    return rows;
  }

  return { newton, fall, g };
})();

if (typeof module !== "undefined") module.exports = OnePoint;

// ---- the page -------------------------------------------------------------------------------

if (typeof document !== "undefined") document.addEventListener("DOMContentLoaded", () => {
  const BLUE = "#0173b2", ORANGE = "#d55e00", GREEN = "#029e73", GREY = "#777";
  const knob = (name) => {
    const input = document.getElementById(name);
    return input.type === "range" ? Number(input.value) : input.value;
  };

  // A canvas with axes: returns functions that draw in the units of x and y.
  function axes(id, [x0, x1], [y0, y1], x_name, y_name) {
    const canvas = document.getElementById(id), scale = window.devicePixelRatio || 1;
    const wide = canvas.clientWidth || 400, high = Math.round(wide * Number(canvas.dataset.ratio));
    canvas.width = wide * scale;
    canvas.height = high * scale;
    const c = canvas.getContext("2d"), left = 46, right = 12, top = 16, bottom = 34;
    c.scale(scale, scale);
    const X = (x) => left + ((x - x0) / (x1 - x0)) * (wide - left - right);
    const Y = (y) => high - bottom - ((y - y0) / (y1 - y0)) * (high - top - bottom);
    const line = (points, colour, width = 2, dash = []) => {
      c.save();
      c.beginPath();
      c.rect(left, top, wide - left - right, high - top - bottom);
      c.clip();
      c.beginPath();
      points.forEach(([x, y], i) => (i ? c.lineTo(X(x), Y(y)) : c.moveTo(X(x), Y(y))));
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.setLineDash(dash);
      c.stroke();
      c.restore();
    };
    const dot = (x, y, colour, text) => {
      c.beginPath();
      c.arc(X(x), Y(y), 4.5, 0, 7);
      c.fillStyle = colour;
      c.fill();
      if (text !== undefined) c.fillText(text, X(x) + 7, Y(y) - 6);
    };
    c.font = "12px sans-serif";
    c.fillStyle = "#333";
    for (const [low, up, across] of [[x0, x1, true], [y0, y1, false]]) {
      const raw = (up - low) / 5, ten = 10 ** Math.floor(Math.log10(raw));
      const gap = ten * [1, 2, 5, 10].find((n) => n * ten >= raw);
      for (let v = Math.ceil(low / gap) * gap; v <= up + 1e-9 * gap; v += gap) {
        const text = String(Number(v.toPrecision(3)));
        c.textAlign = across ? "center" : "right";
        c.fillText(text === "-0" ? "0" : text, across ? X(v) : left - 5, across ? high - bottom + 15 : Y(v) + 4);
        line(across ? [[v, y0], [v, y1]] : [[x0, v], [x1, v]], "#eee", 1);
      }
    }
    if (x0 < 0 && x1 > 0) line([[0, y0], [0, y1]], "#bbb", 1);
    if (y0 < 0 && y1 > 0) line([[x0, 0], [x1, 0]], "#bbb", 1);
    c.textAlign = "right";
    c.fillText(x_name, wide - right, high - 5);
    c.textAlign = "left";
    c.fillText(y_name, 4, 12);
    return { line, dot };
  }

  function impact() {
    const m = 1, e = knob("e"), mu = knob("mu"), rho = m * 10 ** knob("rho");
    const w_n = knob("w_n"), w_t = knob("w_t"), start = knob("lam");
    const data = { free_n: w_n, free_t: w_t, allowed: -e * Math.max(w_n, 0), W: 1 / m, mu, rho, start };
    const iterates = OnePoint.newton(data), end = iterates.at(-1);
    const reach = 1.25 * Math.max(...iterates.flatMap((i) => [Math.abs(i.lam), Math.abs(i.tau)]), 1);
    const speed = 1.25 * Math.max(...iterates.flatMap((i) => [Math.abs(i.w_n), Math.abs(i.w_t)]), 1);

    const left = axes("signorini", [-speed, speed], [-reach, reach], "approach w_n after it [m/s]", "percussion λ [N s]");
    const corner = data.allowed;
    left.line([[corner - reach / rho, -reach], [corner + reach / rho, reach]], ORANGE, 1, [5, 4]);
    left.line([[-speed, 0], [corner, 0], [corner, -reach]], BLUE, 6);
    left.line(iterates.map((i) => [i.w_n, i.lam]), GREEN, 1.5);
    iterates.forEach((i, k) => left.dot(i.w_n, i.lam, GREEN, k));

    const right = axes("coulomb", [-speed, speed], [-reach, reach], "slip w_t after it [m/s]", "friction τ [N s]");
    const b = mu * Math.max(-end.lam, 0);
    right.line([[-speed, -b], [0, -b], [0, b], [speed, b]], BLUE, 6);
    right.line(iterates.map((i) => [i.w_t, i.tau]), GREEN, 1.5);
    iterates.forEach((i, k) => right.dot(i.w_t, i.tau, GREEN, k));

    const status = end.lam >= 0 ? "It does not bear." : Math.abs(end.w_t) < 1e-9 ? "It bears and sticks." : "It bears and slips.";
    const lost = 0.5 * m * (w_n ** 2 + w_t ** 2 - end.w_n ** 2 - end.w_t ** 2);
    document.getElementById("says_impact").textContent =
      `${status} ${iterates.length - 1} Newton iterations; λ = ${end.lam.toFixed(4)} N s, τ = ${end.tau.toFixed(4)} N s; ` +
      `it leaves with w_n = ${end.w_n.toFixed(4)}, w_t = ${end.w_t.toFixed(4)} m/s; energy lost: ${lost.toFixed(4)} J.`;
  }

  function bounce() {
    const set = { theta: knob("theta"), e: knob("e"), mu: knob("mu"), dt: 10 ** knob("dt"), until: 1.6 };
    const rows = OnePoint.fall({ ...set, law: knob("law") });
    const h = 0.5, top = axes("height", [0, 1.6], [-0.06, 0.56], "time [s]", "height [m]");
    const e = set.e, times = [[0, h]];
    for (let t = Math.sqrt((2 * h) / OnePoint.g), v = OnePoint.g * t * e, from = t; v > 0.02 && from < 1.6; v *= e) {
      for (let s = 0; s <= 20; s++) {
        const at = ((2 * v) / OnePoint.g) * (s / 20);
        times.push([from + at, v * at - 0.5 * OnePoint.g * at * at]);
      }
      from += (2 * v) / OnePoint.g;
    }
    const first = Array.from({ length: 21 }, (_, i) => (i / 20) * Math.sqrt((2 * h) / OnePoint.g));
    top.line([...first.map((t) => [t, h - 0.5 * OnePoint.g * t * t]), ...times.slice(1), [1.6, 0]], "#c9c9c9", 6);
    top.line([[0, 0], [1.6, 0]], GREY, 1);
    top.line(rows.map((r) => [r.t, r.y]), BLUE, 2);
    const low = axes("speed", [0, 1.6], [-3.6, 3.6], "time [s]", "velocity [m/s]");
    low.line(rows.map((r) => [r.t, r.v_y]), BLUE, 2);
    low.line(rows.map((r) => [r.t, r.v_x]), ORANGE, 2);
    const last = rows.at(-1), deepest = Math.max(...rows.map((r) => -r.y));
    document.getElementById("says_fall").textContent =
      `Blue: upwards; orange: along the floor; grey: exact. It came ${last.x.toFixed(3)} m far, ` +
      `at most ${(1000 * Math.max(deepest, 0)).toFixed(2)} mm into the floor, and ends with ${last.v_y.toFixed(3)} m/s upwards.`;
  }

  function draw() {
    for (const input of document.querySelectorAll(".knobs input")) {
      const value = Number(input.value), power = input.dataset.power !== undefined;
      input.nextElementSibling.textContent = power ? (10 ** value).toPrecision(2).replace(/e([+-])/, "e$1") : value;
    }
    impact();
    bounce();
  }
  for (const input of document.querySelectorAll(".knobs input, .knobs select")) input.addEventListener("input", draw);
  window.addEventListener("resize", draw);
  draw();
});
