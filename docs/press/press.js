// The page on which a skin is pressed in the browser. Readings of presses and of what is fitted to them come
// from tables.js (make_tables.py says how they are made); here is the fit, and the picture.
"use strict";

const PressedSkin = (() => {
  const T = SKINFIELD_TABLES; // mm, N, kPa
  const logForces = T.forces.map(Math.log);
  const logRadii = T.radii.map(Math.log);
  const MOST = 4; // contacts
  const WORTH = [30, 60]; // what a first or a further contact must lower chi squared by
  const MODEL = 0.02; // share of the highest reading by which tables and presses may differ
  const PRIOR = { mean: Math.log(7), std: 0.6 }; // of the logarithm of a ball's radius, mm

  /** Index and share of a value between the entries of an increasing list, held at its ends. */
  function place(list, value) {
    if (value <= list[0]) return [0, 0];
    const last = list.length - 1;
    if (value >= list[last]) return [last - 1, 1];
    let index = 0;
    while (list[index + 1] < value) index += 1;
    return [index, (value - list[index]) / (list[index + 1] - list[index])];
  }

  /** A row of a table at a distance in mm; nothing is left of a press beyond its end. */
  function along(row, distance) {
    const at = distance / T.step;
    const index = Math.floor(at);
    if (index >= row.length - 1) return 0;
    return row[index] + (at - index) * (row[index + 1] - row[index]);
  }

  /** One quantity of a table by force, per newton as the logarithm of the force goes. */
  function byForce(rows, logForce) {
    const [f, share] = place(logForces, logForce);
    const low = (1 - share) / T.forces[f];
    const high = share / T.forces[f + 1];
    const force = Math.exp(logForce);
    return (distance) => force * (low * along(rows[f], distance) + high * along(rows[f + 1], distance));
  }

  /** A quantity ("readings", "pressure", "indentation") of a ball as a function of the distance. */
  function ofBall(quantity, logForce, logRadius) {
    const [r, share] = place(logRadii, logRadius);
    const small = byForce(T[quantity][r], logForce);
    const large = byForce(T[quantity][r + 1], logForce);
    return (distance) => (1 - share) * small(distance) + share * large(distance);
  }

  const distances = (x, y) => T.taxels.map(([tx, ty]) => Math.hypot(tx - x, ty - y));

  /** Numbers of a normal distribution, the same for the same seed. */
  function normal(seed) {
    let state = seed >>> 0;
    const uniform = () => {
      state = (state + 0x6d2b79f5) >>> 0;
      let t = Math.imul(state ^ (state >>> 15), state | 1);
      t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
      return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
    };
    return () => Math.sqrt(-2 * Math.log(1 - uniform())) * Math.cos(2 * Math.PI * uniform());
  }

  /** Readings of presses {x, y, force, tool}; those of several add, as they do a few thicknesses apart. */
  function read(presses, noise, seed = 1) {
    const next = normal(seed);
    const readings = T.taxels.map(() => noise * next());
    for (const press of presses) {
      const response = byForce(T.tools[press.tool], Math.log(press.force));
      distances(press.x, press.y).forEach((distance, taxel) => (readings[taxel] += response(distance)));
    }
    return readings;
  }

  const expected = ([x, y, logForce, logRadius]) => {
    const response = ofBall("readings", logForce, logRadius);
    return distances(x, y).map(response);
  };

  /** Solve a positive definite system; also its inverse, for the covariance. */
  function inverse(matrix) {
    const n = matrix.length;
    const rows = matrix.map((row, i) => [...row, ...row.map((_, j) => (i === j ? 1 : 0))]);
    for (let i = 0; i < n; i += 1) {
      let best = i;
      for (let k = i + 1; k < n; k += 1) if (Math.abs(rows[k][i]) > Math.abs(rows[best][i])) best = k;
      [rows[i], rows[best]] = [rows[best], rows[i]];
      const pivot = rows[i][i];
      if (!(Math.abs(pivot) > 1e-300)) return null;
      rows[i] = rows[i].map((value) => value / pivot);
      for (let k = 0; k < n; k += 1) {
        if (k === i) continue;
        const factor = rows[k][i];
        if (factor) rows[k] = rows[k].map((value, j) => value - factor * rows[i][j]);
      }
    }
    return rows.map((row) => row.slice(n));
  }

  const STEPS = [0.02, 0.02, 1e-3, 1e-2]; // of the differences: mm, mm, and of the logarithms
  const LOW = [-Infinity, -Infinity, Math.log(0.01), logRadii[0]];
  const HIGH = [Infinity, Infinity, Math.log(8), logRadii.at(-1)];

  /** Weighted residuals of contacts, those of the prior at the end, and chi squared. */
  function judge(readings, contacts, noise) {
    const model = readings.map(() => 0);
    const peak = Math.max(0.02, ...readings);
    for (const contact of contacts) expected(contact).forEach((value, taxel) => (model[taxel] += value));
    const weight = 1 / Math.hypot(noise, MODEL * peak);
    const rest = readings.map((value, taxel) => (value - model[taxel]) * weight);
    for (const contact of contacts) rest.push((PRIOR.mean - contact[3]) / PRIOR.std);
    return { rest, weight, chi: rest.reduce((sum, value) => sum + value * value, 0) };
  }

  /** Levenberg and Marquardt's steps over all numbers of all contacts. */
  function refine(readings, start, noise) {
    let contacts = start.map((contact) => [...contact]);
    let now = judge(readings, contacts, noise);
    let damping = 1e-2;
    let hessian = [];
    for (let step = 0; step < 40; step += 1) {
      const slopes = [];
      contacts.forEach((contact, index) => {
        const base = expected(contact);
        STEPS.forEach((delta, parameter) => {
          const moved = [...contact];
          moved[parameter] += delta;
          const slope = expected(moved).map((value, taxel) => ((value - base[taxel]) / delta) * now.weight);
          contacts.forEach((_, other) => slope.push(other === index && parameter === 3 ? 1 / PRIOR.std : 0));
          slopes.push(slope);
        });
      });
      const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
      hessian = slopes.map((a) => slopes.map((b) => dot(a, b)));
      const gradient = slopes.map((a) => dot(a, now.rest));
      let better = false;
      while (!better && damping < 1e6) {
        const damped = hessian.map((row, i) => row.map((v, j) => (i === j ? v * (1 + damping) + 1e-12 : v)));
        const solved = inverse(damped);
        const moved = contacts.map((contact, c) =>
          contact.map((value, p) => {
            const change = solved ? dot(solved[4 * c + p], gradient) : 0;
            return Math.min(HIGH[p], Math.max(LOW[p], value + Math.max(-2, Math.min(2, change))));
          }),
        );
        const then = judge(readings, moved, noise);
        if (then.chi < now.chi) {
          better = then.chi < now.chi - 1e-2;
          if (!better) damping = Infinity;
          contacts = moved;
          now = then;
          damping = Math.max(1e-6, damping / 8);
        } else damping *= 8;
      }
      if (!better) break;
    }
    return { contacts, chi: now.chi, covariance: inverse(hessian) };
  }

  let templates = null; // of presses of 0.5 N all over the skin, made when first needed

  function makeTemplates() {
    const [xs, ys] = [0, 1].map((axis) => T.taxels.map((taxel) => taxel[axis]));
    const made = [];
    for (let x = Math.min(...xs) - 3; x <= Math.max(...xs) + 3; x += 2) {
      for (let y = Math.min(...ys) - 3; y <= Math.max(...ys) + 3; y += 2) {
        for (const logRadius of [logRadii[0], logRadii[2], logRadii[4]]) {
          const shape = Float64Array.from(expected([x, y, Math.log(0.5), logRadius]));
          made.push({ x, y, logRadius, shape, power: shape.reduce((sum, v) => sum + v * v, 1e-6) });
        }
      }
    }
    return made;
  }

  /** The most promising starts of one more contact in what is left, a few millimetres apart. */
  function propose(rest) {
    templates ??= makeTemplates();
    const starts = templates.map(({ x, y, logRadius, shape, power }) => {
      let match = 0;
      for (let taxel = 0; taxel < rest.length; taxel += 1) match += shape[taxel] * rest[taxel];
      const force = Math.min(4, Math.max(0.05, (0.5 * match) / power));
      return { gain: match > 0 ? (match * match) / power : 0, contact: [x, y, Math.log(force), logRadius] };
    });
    starts.sort((a, b) => b.gain - a.gain);
    const apart = [];
    for (const { contact } of starts) {
      if (apart.every(([x, y]) => Math.hypot(x - contact[0], y - contact[1]) > 3.5)) apart.push(contact);
      if (apart.length === 4) break;
    }
    return apart;
  }

  /** What touches: contacts with x, y in mm, force in N, radius in mm, each number with its standard error. */
  function answer(readings, noise) {
    let fit = { contacts: [], chi: judge(readings, [], noise).chi, covariance: [] };
    while (fit.contacts.length < MOST) {
      const rest = judge(readings, fit.contacts, noise);
      const left = readings.map((_, taxel) => rest.rest[taxel] / rest.weight);
      const tries = propose(left).map((start) => refine(readings, [...fit.contacts, start], noise));
      const more = tries.reduce((best, one) => (one.chi < best.chi ? one : best));
      if (!more.covariance || more.chi > fit.chi - WORTH[Math.min(1, fit.contacts.length)]) break;
      fit = more;
    }
    return fit.contacts.map(([x, y, logForce, logRadius], index) => {
      const std = [0, 1, 2, 3].map((p) => Math.sqrt(Math.max(0, fit.covariance[4 * index + p][4 * index + p])));
      const force = Math.exp(logForce);
      return { x, y, force, radius: Math.exp(logRadius), logForce, logRadius, forceStd: force * std[2], placeStd: Math.hypot(std[0], std[1]) };
    });
  }

  // A link holds the presses: #noise=0.002&press=x,y,force,tool&press=...

  function toLink({ presses, noise }) {
    const tools = Object.keys(T.tools);
    const parts = presses.map((p) => `press=${p.x.toFixed(1)},${p.y.toFixed(1)},${p.force.toFixed(2)},${tools.indexOf(p.tool)}`);
    return `#${[`noise=${noise}`, ...parts].join("&")}`;
  }

  function fromLink(text) {
    const tools = Object.keys(T.tools);
    const fields = new URLSearchParams(text.replace(/^#/, ""));
    const noise = [0.0005, 0.002, 0.005].find((value) => value === Number(fields.get("noise")));
    const presses = fields.getAll("press").slice(0, 3).map((entry) => {
      const [x, y, force, tool] = entry.split(",").map(Number);
      return { x, y, force, tool: tools[tool] };
    });
    const sound = (p) => Math.hypot(p.x, p.y) < 40 && p.force >= 0.05 && p.force <= 4 && p.tool;
    return presses.length && presses.every(sound) ? { presses, noise: noise ?? 0.002 } : null;
  }

  return { T, read, answer, ofBall, toLink, fromLink };
})();

/** The picture and its controls, in the elements of the page. */
function startPressedSkin(root) {
  const { T, read, answer, ofBall, toLink, fromLink } = PressedSkin;
  const [canvas, table, note] = ["canvas", "tbody", ".press-note"].map((name) => root.querySelector(name));
  const [tool, force, noise] = ["tool", "force", "noise"].map((name) => root.querySelector(`[name=${name}]`));
  const HALF = 32; // mm from the middle of the picture to its edges
  const first = { presses: [{ x: 8, y: 6, force: 1.5, tool: "ball 8 mm" }], noise: 0.002 };
  const state = fromLink(location.hash) ?? first;
  let chosen = 0;
  let found = [];
  let waiting = null; // an update of the next picture

  for (const name of Object.keys(T.tools)) tool.add(new Option(name, name));
  noise.value = String(state.noise);

  const mm = (event) => {
    const box = canvas.getBoundingClientRect();
    const scale = (2 * HALF) / box.width;
    return [(event.clientX - box.left) * scale - HALF, HALF - (event.clientY - box.top) * scale];
  };

  function update() {
    const readings = read(state.presses, state.noise);
    found = answer(readings, state.noise);
    draw(readings);
    list();
    const press = state.presses[chosen];
    if (press) {
      tool.value = press.tool;
      force.value = String(press.force);
      root.querySelector("output").textContent = `${press.force.toFixed(2)} N`;
    }
    history.replaceState(null, "", toLink(state));
  }

  /** Contacts found, each with the press that it is nearest to. */
  function list() {
    const left = [...found];
    const rows = state.presses.map((press) => {
      left.sort((a, b) => Math.hypot(a.x - press.x, a.y - press.y) - Math.hypot(b.x - press.x, b.y - press.y));
      const near = left.length && Math.hypot(left[0].x - press.x, left[0].y - press.y) < 8 ? left.shift() : null;
      return [press, near];
    });
    for (const contact of left) rows.push([null, contact]);
    const cell = (text) => Object.assign(document.createElement("td"), { textContent: text });
    table.replaceChildren(
      ...rows.map(([press, contact]) => {
        const row = document.createElement("tr");
        if (contact) row.dataset.force = contact.force;
        row.append(
          cell(press ? `${press.force.toFixed(2)} N` : "nothing"),
          cell(contact ? `${contact.force.toFixed(2)} ± ${contact.forceStd.toFixed(2)} N` : "not found"),
          cell(press ? `${press.x.toFixed(1)}, ${press.y.toFixed(1)}` : "–"),
          cell(contact ? `${contact.x.toFixed(1)}, ${contact.y.toFixed(1)} ± ${contact.placeStd.toFixed(1)}` : "–"),
        );
        return row;
      }),
    );
    const lost = rows.some(([press, contact]) => press && !contact);
    note.textContent = !state.presses.length
      ? "Click on the skin to press it."
      : lost ? "A press between the taxels raises none of them: this skin cannot see it. Move it a few millimetres." : "";
  }

  const colours = () => {
    const probe = getComputedStyle(root);
    return { ink: probe.color, skin: probe.getPropertyValue("--press-skin").trim(), warm: probe.getPropertyValue("--press-truth").trim() };
  };

  function draw(readings) {
    const ratio = window.devicePixelRatio || 1;
    const size = Math.round(canvas.clientWidth * ratio) || 600;
    canvas.width = canvas.height = size;
    const context = canvas.getContext("2d");
    const scale = size / (2 * HALF);
    const at = (x, y) => [(x + HALF) * scale, (HALF - y) * scale];
    const { ink, skin, warm } = colours();
    const small = Object.assign(document.createElement("canvas"), { width: 240, height: 240 });
    small.getContext("2d").putImageData(relief(240, skin), 0, 0);
    context.drawImage(small, 0, 0, size, size);
    context.lineWidth = ratio;
    T.taxels.forEach(([x, y], taxel) => {
      context.beginPath();
      context.arc(...at(x, y), (T.pad / 2) * scale, 0, 7);
      context.strokeStyle = ink;
      context.globalAlpha = 0.25;
      context.stroke();
      context.globalAlpha = Math.min(0.55, Math.max(0, readings[taxel] / 0.25));
      context.fillStyle = ink;
      context.fill();
    });
    context.globalAlpha = 1;
    const letters = Math.round(13 * ratio);
    context.font = `600 ${letters}px system-ui, sans-serif`;
    context.lineWidth = 2 * ratio;
    state.presses.forEach((press, index) => {
      context.setLineDash([5 * ratio, 4 * ratio]);
      context.strokeStyle = warm;
      context.lineWidth = (index === chosen ? 3 : 1.5) * ratio;
      context.beginPath();
      context.arc(...at(press.x, press.y), T.sizes[press.tool] * scale, 0, 7);
      context.stroke();
    });
    context.setLineDash([]);
    context.lineWidth = 2 * ratio;
    for (const contact of found) {
      const [x, y] = at(contact.x, contact.y);
      context.strokeStyle = context.fillStyle = ink;
      context.beginPath();
      context.arc(x, y, Math.max(contact.placeStd, 0.5) * scale, 0, 7);
      context.moveTo(x, y);
      context.lineTo(x + 6 * scale, y - 6 * scale);
      context.stroke();
      context.fillText(`${contact.force.toFixed(2)} N`, x + 6.4 * scale, y - 6 * scale);
    }
    const [left, low] = at(-HALF + 3, -HALF + 3);
    context.fillStyle = ink;
    context.fillRect(left, low, 10 * scale, 2 * ratio);
    context.fillText("10 mm", left, low - 5 * ratio);
  }

  /** Pressure as colour, the dent three times as deep as light and shade. */
  function relief(size, skin) {
    const image = new ImageData(size, size);
    const probe = document.createElement("canvas").getContext("2d");
    probe.fillStyle = skin || "#d8d2c8";
    probe.fillRect(0, 0, 1, 1);
    const base = probe.getImageData(0, 0, 1, 1).data;
    const fields = found.map((c) => ({
      ...c,
      pressure: ofBall("pressure", c.logForce, c.logRadius),
      depth: ofBall("indentation", c.logForce, c.logRadius),
    }));
    const pixel = (2 * HALF) / size;
    const depth = (x, y) => fields.reduce((sum, c) => sum + c.depth(Math.hypot(x - c.x, y - c.y)), 0);
    for (let row = 0; row < size; row += 1) {
      for (let column = 0; column < size; column += 1) {
        const [x, y] = [(column + 0.5) * pixel - HALF, HALF - (row + 0.5) * pixel];
        const near = fields.some((c) => Math.hypot(x - c.x, y - c.y) < 14);
        const here = near ? depth(x, y) : 0;
        const slope = near ? (3 * (depth(x + 0.3, y) - here + here - depth(x, y + 0.3))) / 0.3 : 0;
        const light = Math.max(0.45, Math.min(1.35, 1 - 0.35 * slope));
        const pressure = near ? fields.reduce((sum, c) => sum + c.pressure(Math.hypot(x - c.x, y - c.y)), 0) : 0;
        const share = 1 - Math.exp(-pressure / 60);
        const index = 4 * (row * size + column);
        [235, 94, 40].forEach((value, channel) => {
          image.data[index + channel] = Math.min(255, light * (base[channel] + share * (value - base[channel])));
        });
        image.data[index + 3] = 255;
      }
    }
    return image;
  }

  function move(x, y) {
    const reach = HALF - 1;
    Object.assign(state.presses[chosen], {
      x: Math.max(-reach, Math.min(reach, x)),
      y: Math.max(-reach, Math.min(reach, y)),
    });
    waiting ??= requestAnimationFrame(() => {
      waiting = null;
      update();
    });
  }

  canvas.addEventListener("pointerdown", (event) => {
    const [x, y] = mm(event);
    const grabbed = state.presses.findIndex((p) => Math.hypot(p.x - x, p.y - y) < 4);
    if (grabbed >= 0) chosen = grabbed;
    else if (!state.presses.length || (event.shiftKey && state.presses.length < 3)) {
      state.presses.push({ x, y, force: Number(force.value), tool: tool.value });
      chosen = state.presses.length - 1;
    }
    canvas.setPointerCapture(event.pointerId);
    canvas.focus();
    move(x, y);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (event.buttons && state.presses.length) move(...mm(event));
  });
  canvas.addEventListener("keydown", (event) => {
    const press = state.presses[chosen];
    const by = event.shiftKey ? 5 : 1;
    const steps = { ArrowLeft: [-by, 0], ArrowRight: [by, 0], ArrowUp: [0, by], ArrowDown: [0, -by] };
    if (!press || !(event.key in steps)) return;
    event.preventDefault();
    move(press.x + steps[event.key][0], press.y + steps[event.key][1]);
  });
  force.addEventListener("input", () => {
    if (state.presses[chosen]) state.presses[chosen].force = Number(force.value);
    update();
  });
  tool.addEventListener("change", () => {
    if (state.presses[chosen]) state.presses[chosen].tool = tool.value;
    update();
  });
  noise.addEventListener("change", () => {
    state.noise = Number(noise.value);
    update();
  });
  root.querySelector("[name=add]").addEventListener("click", () => {
    if (state.presses.length >= 3) return;
    const free = [[-12, 8], [0, -14], [12, 8]].find(([x, y]) => state.presses.every((p) => Math.hypot(p.x - x, p.y - y) > 9));
    state.presses.push({ x: free[0], y: free[1], force: Number(force.value), tool: tool.value });
    chosen = state.presses.length - 1;
    update();
  });
  root.querySelector("[name=lift]").addEventListener("click", () => {
    state.presses.splice(chosen, 1);
    chosen = Math.max(0, state.presses.length - 1);
    update();
  });
  root.querySelector("[name=link]").addEventListener("click", async (event) => {
    const copied = await navigator.clipboard?.writeText(location.href).then(() => true, () => false);
    event.target.textContent = copied ? "Copied" : "The link is in the address bar";
  });
  new ResizeObserver(update).observe(canvas);
  new MutationObserver(update).observe(document.documentElement, { attributeFilter: ["data-theme"] });
}

if (typeof document !== "undefined") {
  const begin = () => document.querySelectorAll(".pressed-skin").forEach(startPressedSkin);
  document.readyState === "loading" ? document.addEventListener("DOMContentLoaded", begin) : begin();
}
