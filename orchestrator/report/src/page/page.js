"use strict";
// Draws the charts of the page from its data. Charts over time share cursor and zoom.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  // As in the picture of the section (Okabe and Ito), told apart by their dashes too, in grey.
  const COLOURS = ["#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#000000", "#56b4e9"];
  const DASHES = [[], [7, 3], [2, 2], [10, 3, 2, 3], [], [5, 5], [1, 3]];
  const BORDERS = ["solid", "dashed", "dotted", "dashed", "solid", "dashed", "dotted"];
  const INK = "#59636e";
  const GRID = { stroke: "#e6eaee", width: 1 };
  const FONT = "12px system-ui, -apple-system, 'Segoe UI', Roboto, Arial, sans-serif";
  // Pixels, of a chart over time: four fit on a page.
  const HEIGHT = 190;
  const PRINTED = { width: 660, height: 150 };
  // Least part of the largest value that a logarithmic scale shows.
  const LEAST = 1e-9;
  // Abscissae: what they are, unit, decimals at the cursor, and whether the scale is logarithmic.
  const TIMES = { name: "t", unit: " s", decimals: 4, logarithmic: false };
  const PERIODS = { name: "T", unit: " s", decimals: 3, logarithmic: true };
  const NUMBERS = { unit: "", decimals: 2, logarithmic: false };
  const ofTime = [];
  let moving = false;

  const minus = text => text.replace("-", "−");
  const shown = value => value == null ? "" : minus(Math.abs(value) >= 1e5 || (value !== 0 && Math.abs(value) < 1e-3)
    ? value.toExponential(2) : String(+value.toPrecision(4)));

  function abscissa(chart, time) {
    const { Rows, Times, Periods, Numbers } = chart.abscissa;
    if (Times) return { along: TIMES, values: Times };
    if (Periods) return { along: PERIODS, values: Periods };
    if (Numbers) return { along: { ...NUMBERS, name: Numbers.name }, values: Numbers.values };
    let row = 0;
    return { along: TIMES, values: Rows.map(step => time[row += step]) };
  }

  // What a chart draws. The line of another run has instants of its own: where a line has no value, `undefined`, it continues.
  function content(chart) {
    const { along, values } = abscissa(chart, data.time);
    const lines = chart.series.map((line, index) => ({ ...line, index }));
    if (!chart.beside) return { along, lines, table: [values, ...lines.map(line => line.values)] };
    const other = abscissa(chart.beside, data.beside);
    const beside = chart.beside.series.map(line => ({ ...line, index: 1 }));
    const tables = [[values, ...lines.map(line => line.values)], [other.values, ...beside.map(line => line.values)]];
    const drawn = lines.length ? along : other.along;
    return { along: drawn, lines: [...lines, ...beside], table: uPlot.join(tables.filter(table => table.length > 1)) };
  }

  // Of a line without a value at the cursor the nearest one.
  function nearest(u, line, index) {
    const values = u.data[line];
    for (let away = 0; line > 0 && away < 50; away++) {
      if (values[index - away] !== undefined) return index - away;
      if (values[index + away] !== undefined) return index + away;
    }
    return index;
  }

  // A zoom of one chart over time is one of all.
  function follow(chart) {
    if (moving) return;
    moving = true;
    const { min, max } = chart.scales.x;
    for (const other of ofTime) {
      const { x } = other.scales;
      if (x.min !== min || x.max !== max) other.setScale("x", { min, max });
    }
    moving = false;
  }

  function marks(chart) {
    return u => {
      const ctx = u.ctx;
      ctx.save();
      ctx.strokeStyle = ctx.fillStyle = INK;
      ctx.lineWidth = uPlot.pxRatio;
      ctx.font = `${12 * uPlot.pxRatio}px system-ui, Arial, sans-serif`;
      ctx.setLineDash([3 * uPlot.pxRatio, 3 * uPlot.pxRatio]);
      const { left, top, width, height } = u.bbox;
      chart.marks.forEach((mark, index) => {
        ctx.beginPath();
        if (mark.horizontal) {
          const y = u.valToPos(mark.at, "y", true);
          ctx.moveTo(left, y); ctx.lineTo(left + width, y); ctx.stroke();
          ctx.textAlign = "right";
          ctx.fillText(mark.name, left + width - 4, y - 4 * uPlot.pxRatio);
        } else {
          const x = u.valToPos(mark.at, "x", true);
          ctx.moveTo(x, top); ctx.lineTo(x, top + height); ctx.stroke();
          ctx.textAlign = index % 2 ? "left" : "right";
          ctx.fillText(mark.name, x + (index % 2 ? 5 : -5) * uPlot.pxRatio, top + (14) * uPlot.pxRatio);
        }
      });
      ctx.restore();
    };
  }

  // The whole run, or both, in place of all that a chart has.
  const times = [data.time, data.beside ?? []].filter(time => time.length);
  const ends = [Math.min(...times.map(time => time[0])), Math.max(...times.map(time => time[time.length - 1]))];
  const whole = values => (u, min, max) => min === values[0] && max === values[values.length - 1] ? ends : [min, max];

  function ranges(chart) {
    if (chart.range) return () => chart.range;
    if (chart.logarithmic) {
      return (u, min, max) => min == null ? [1, 10]
        : [10 ** Math.floor(Math.log10(Math.max(min, max * LEAST))), 10 ** Math.ceil(Math.log10(max))];
    }
    return (u, min, max) => {
      if (min == null) return [0, 1];
      const margin = (max - min || Math.abs(max) || 1) * 0.06;
      return [min >= 0 && min < 0.3 * max ? 0 : min - margin, max + margin];
    };
  }

  // Whole powers of ten, six at most.
  function decades(u, axis, min, max) {
    const [first, last] = [min, max].map(value => Math.round(Math.log10(value)));
    const step = Math.max(1, Math.ceil((last - first) / 6));
    return Array.from({ length: Math.floor((last - first) / step) + 1 }, (_, i) => 10 ** (first + i * step));
  }

  function draw(place) {
    const chart = data.charts[+place.dataset.chart];
    const { along, lines, table } = content(chart);
    const values = table[0];
    const overTime = along === TIMES;
    const series = lines.map(({ index, ...line }) => ({
      label: line.name,
      stroke: COLOURS[index % COLOURS.length],
      width: overTime ? 1.2 : 1.8,
      dash: DASHES[index % DASHES.length],
      points: { show: false },
      spanGaps: false,
      value: (u, value) => shown(value),
    }));
    const axis = { stroke: INK, grid: GRID, ticks: { ...GRID, size: 4 }, font: FONT };
    const options = {
      width: place.clientWidth,
      height: overTime ? HEIGHT : 330,
      padding: [8, 12, 0, 0],
      legend: { markers: { width: 2, stroke: (u, i) => u.series[i].stroke(u, i), dash: (u, i) => BORDERS[(lines[i - 1]?.index ?? 0) % BORDERS.length] } },
      cursor: overTime
        ? { sync: { key: "time", scales: ["x", null], setSeries: false, filters: { pub: type => type === "mousemove" || type === "mouseleave" } }, drag: { x: true, y: false }, points: { size: 6 } }
        : { drag: { x: false, y: false }, points: { size: 6 } },
      scales: {
        x: overTime ? { time: false, range: whole(values) } : { time: false, distr: along.logarithmic ? 3 : 1, range: () => [values[0], values[values.length - 1]] },
        y: { distr: chart.logarithmic ? 3 : 1, range: ranges(chart) },
      },
      series: [{ label: along.name, value: (u, value) => value == null ? "" : value.toFixed(along.decimals) + along.unit }, ...series],
      axes: [
        { ...axis, size: 30, filter: along.logarithmic ? (u, ticks) => ticks.map(t => /^[125]/.test(t.toExponential(0)) ? t : null) : undefined, values: (u, ticks) => ticks.map(t => t == null ? null : +t.toPrecision(10) + along.unit) },
        { ...axis, size: 62, ...(chart.logarithmic ? { splits: decades, filter: (u, ticks) => ticks } : {}), values: (u, ticks) => ticks.map(t => t == null ? null : Math.abs(t) >= 1e5 || (t !== 0 && Math.abs(t) < 1e-4)
            ? "10" + String(Math.round(Math.log10(Math.abs(t)))).replace(/./g, c => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻") : minus(String(+t.toPrecision(6)))) },
      ],
      hooks: { draw: [marks(chart)] },
    };
    if (chart.beside) options.cursor.dataIdx = nearest;
    if (overTime) options.hooks.setScale = [(u, key) => { if (key === "x") follow(u); }];
    place.textContent = "";
    const drawn = new uPlot(options, table, place);
    if (overTime) {
      ofTime.push(drawn);
      drawn.over.addEventListener("click", () => document.dispatchEvent(new CustomEvent("instant", { detail: drawn.posToVal(drawn.cursor.left, "x") })));
    }
    return { place, drawn, overTime };
  }

  const all = [...document.querySelectorAll("[data-chart]")].map(draw);
  const fit = printed => {
    for (const { place, drawn, overTime } of all) {
      const height = !overTime ? drawn.height : printed ? PRINTED.height : HEIGHT;
      drawn.setSize({ width: printed ? PRINTED.width : place.clientWidth, height });
    }
  };
  let waiting = 0;
  addEventListener("resize", () => { clearTimeout(waiting); waiting = setTimeout(fit, 100); });
  addEventListener("beforeprint", () => fit(true));
  addEventListener("afterprint", () => fit());
})();
