"use strict";
// Draws the dam in motion from the data of the page.
(() => {
  const { animation } = JSON.parse(document.getElementById("data").textContent);
  const place = document.getElementById("dam-in-motion");
  if (!animation || !place) return;
  const { outline, times, first, motion, waters, readings } = animation;
  const [canvas, play, slide, speed, scale] = ["canvas", ".play", ".instant", ".speed", ".magnification"].map(of => place.querySelector(of));
  const [clock, values] = ["time", ".readings"].map(of => place.querySelector(of));
  const ctx = canvas.getContext("2d");
  const [CONCRETE, RIM, WATER, PUSH, PULL, INK, UNLOADED] = ["#d9dadb", "#222", "#dcebf5", "#0072b2", "#d55e00", "#59636e", "#8b949e"];
  // Parts of the height: the largest motion that is drawn by default, the largest of all, the largest pressure, its zero line's distance.
  const [DRAWN, MOST, WIDE, APART] = [0.06, 0.35, 0.2, 0.32];
  const HEIGHT = 440;

  const summed = ({ unit, rows }) => {
    let sum = rows[0].map(() => 0);
    return rows.map(row => { sum = sum.map((value, i) => value + row[i]); return sum.map(count => count * unit); });
  };
  const moved = summed(motion);
  const pressures = waters.map(water => summed(water.pressure));
  const all = outline.flat();
  const bounds = axis => [Math.min(...all.map(point => point[axis])), Math.max(...all.map(point => point[axis]))];
  const [[x0, x1], [y0, y1]] = [0, 1].map(bounds);
  const height = y1 - y0;
  const largest = rows => rows.reduce((most, row) => row.reduce((m, value) => Math.max(m, Math.abs(value)), most), 0);
  const peak = largest(moved);
  const most = pressures.reduce((m, rows) => Math.max(m, largest(rows)), 0);
  const isWet = downstream => waters.some(water => water.downstream === downstream);
  const left = x0 - (isWet(false) ? APART + WIDE + 0.05 : 0.15) * height;
  const right = x1 + (isWet(true) ? APART + WIDE + 0.05 : 0.15) * height;
  const [bottom, top] = [y0 - 0.04 * height, y1 + 0.06 * height];

  // Magnifications of 1, 2 or 5 times a power of ten.
  const steps = [];
  for (let power = 1; power <= 1e6; power *= 10) steps.push(power, 2 * power, 5 * power);
  const fitting = peak > 0 ? steps.filter(m => m === 1 || m * peak <= MOST * height) : [1];
  const usual = fitting.filter(m => m * peak <= DRAWN * height).pop() ?? 1;
  fitting.forEach(m => scale.add(new Option(m === 1 ? "× 1" : `× ${m}`, m, m === usual, m === usual)));

  let now = times[first];
  let playing = null;

  // The number of the instant before, and cubics through four of them.
  function before(time) {
    let [low, high] = [0, times.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle; else high = middle;
    }
    return low;
  }
  function at(rows, time) {
    const i = before(time);
    const j = Math.min(i + 1, rows.length - 1);
    if (i === j) return rows[i];
    const s = Math.min(1, Math.max(0, (time - times[i]) / (times[j] - times[i])));
    const [h, k] = [Math.max(i - 1, 0), Math.min(j + 1, rows.length - 1)];
    const length = times[j] - times[i];
    const slope = (a, b, n) => times[b] > times[a] ? (rows[b][n] - rows[a][n]) / (times[b] - times[a]) * length : 0;
    const [s2, s3] = [s * s, s * s * s];
    return rows[i].map((value, n) => (2 * s3 - 3 * s2 + 1) * value + (s3 - 2 * s2 + s) * slope(h, j, n)
      + (3 * s2 - 2 * s3) * rows[j][n] + (s3 - s2) * slope(i, k, n));
  }

  function draw() {
    const ratio = Math.max(devicePixelRatio, 2);
    const px = Math.min(place.clientWidth / (right - left), HEIGHT / (top - bottom));
    const [width, tall] = [px * (right - left), px * (top - bottom)];
    canvas.style.width = `${width}px`;
    canvas.style.height = `${tall}px`;
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(tall * ratio)];
    const to = ([x, y]) => [(x - left) * px * ratio, (top - y) * px * ratio];
    const line = points => points.forEach((point, i) => ctx[i ? "lineTo" : "moveTo"](...to(point)));
    const stroke = (colour, thick, dashes = []) => {
      ctx.strokeStyle = colour; ctx.lineWidth = thick * ratio; ctx.setLineDash(dashes.map(d => d * ratio)); ctx.stroke();
    };
    const magnified = +scale.value;
    const motion = at(moved, now);
    const points = all.map(([x, y], i) => [x + magnified * motion[2 * i], y + magnified * motion[2 * i + 1]]);

    for (const { downstream, level, face } of waters) {
      const end = downstream ? right : left;
      const wet = face.map(number => points[number]);
      if (!wet.length) continue;
      ctx.beginPath();
      line([[end, all[face[0]][1]], ...wet, [wet[wet.length - 1][0], level], [end, level]]);
      ctx.closePath(); ctx.fillStyle = WATER; ctx.fill();
      ctx.beginPath(); line([[end, level], [wet[wet.length - 1][0], level]]); stroke(PUSH, 1);
    }
    ctx.beginPath(); line([[left, y0], [right, y0]]); stroke(UNLOADED, 1);
    ctx.beginPath();
    let number = 0;
    for (const polygon of outline) {
      line(points.slice(number, number += polygon.length));
      ctx.closePath();
    }
    ctx.fillStyle = CONCRETE; ctx.fill("nonzero"); stroke(RIM, 1.2);
    ctx.beginPath();
    for (const polygon of outline) { line(polygon); ctx.closePath(); }
    stroke(UNLOADED, 0.8, [3, 3]);

    waters.forEach(({ downstream, points: face }, index) => {
      const zero = downstream ? x1 + APART * height : x0 - APART * height;
      const towards = downstream ? -1 : 1;
      const pressure = at(pressures[index], now);
      const size = most > 0 ? WIDE * height / most : 0;
      const ends = face.map(([, y], i) => [zero + towards * size * pressure[i], y]);
      for (const [colour, sign] of [[PUSH, 1], [PULL, -1]]) {
        ctx.beginPath();
        line([[zero, face[0][1]], ...ends.map(([x, y]) => [zero + towards * sign * Math.max(0, sign * towards * (x - zero)), y]), [zero, face[face.length - 1][1]]]);
        ctx.closePath(); ctx.fillStyle = colour; ctx.globalAlpha = 0.35; ctx.fill(); ctx.globalAlpha = 1;
      }
      ctx.beginPath(); line(ends); stroke(INK, 1.4);
      ctx.beginPath(); line([[zero, face[0][1]], [zero, face[face.length - 1][1]]]); stroke(INK, 0.8);
    });

    clock.textContent = `t = ${now.toFixed(3)} s`;
    // The nearest instant, so that every number is one of the run.
    const i = before(now);
    const near = i + 1 < times.length && times[i + 1] - now < now - times[i] ? i + 1 : i;
    values.textContent = readings.map(({ name, values: of }) => {
      const [what, unit] = name.split(/, (?=[^,]*$)/);
      return `${what} ${of[near] == null ? "–" : String(+of[near].toPrecision(4)).replace("-", "−")}\u202f${unit}`.replaceAll(" ", "\u00a0");
    }).join(" · ");
    slide.value = now;
  }

  function go(time) {
    now = Math.min(times[times.length - 1], Math.max(times[0], time));
    draw();
  }
  function stop() {
    cancelAnimationFrame(playing);
    playing = null;
    play.textContent = "Play";
  }
  function start() {
    play.textContent = "Pause";
    if (now >= times[times.length - 1]) now = times[0];
    let last = performance.now();
    const on = moment => {
      go(now + (moment - last) / 1000 * speed.value);
      last = moment;
      if (now < times[times.length - 1]) playing = requestAnimationFrame(on); else stop();
    };
    playing = requestAnimationFrame(on);
  }

  [slide.min, slide.max, slide.step] = [times[0], times[times.length - 1], "any"];
  play.addEventListener("click", () => playing === null ? start() : stop());
  slide.addEventListener("input", () => { stop(); go(+slide.value); });
  scale.addEventListener("change", draw);
  document.addEventListener("instant", event => { stop(); go(event.detail); });
  ["resize", "beforeprint", "afterprint"].forEach(event => addEventListener(event, draw));
  draw();
})();
