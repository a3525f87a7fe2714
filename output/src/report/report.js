"use strict";
// Curves by uPlot (drag: zoom, double click: all; the legend tells values under the pointer), frames as a player.
(() => {
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  // The nearest row in which the series has a value, within ten pixels: times of others lie between its own.
  const nearest = (plot, index, row) => {
    const values = plot.data[index];
    const place = (at) => plot.valToPos(plot.data[0][at], "x");
    for (let off = 0; off < values.length; off++) {
      const at = [row - off, row + off].find((at) => values[at] !== undefined);
      if (at !== undefined) return Math.abs(place(at) - place(row)) < 10 || !plot.series[index].marks ? at : null;
    }
    return null;
  };

  // Powers of ten, eight at most.
  const decades = (plot, axis, low, high) => {
    const [first, last] = [Math.floor(Math.log10(low)), Math.ceil(Math.log10(high))];
    const step = Math.max(1, Math.ceil((last - first) / 8));
    return Array.from({ length: Math.floor((last - first) / step) + 1 }, (_, index) => 10 ** (last - index * step)).reverse();
  };
  const powers = {
    splits: decades,
    filter: (plot, splits) => splits,
    values: (plot, splits) => splits.map((value) => value.toExponential(0)),
  };

  function chart(host) {
    const given = JSON.parse(host.querySelector("script").textContent);
    const bars = given.series.flatMap((s) => s.bars ?? []);
    const ends = bars.flatMap(([, low, high]) => [low, high]).filter((value) => value !== null);
    const colour = (index) => css(`--c${index % 8}`);
    const short = (plot, value) => (value == null ? "–" : Number(value.toPrecision(5)).toString());
    const axis = { stroke: css("--soft"), grid: { stroke: css("--line"), width: 1 }, ticks: { stroke: css("--line"), width: 1 } };
    const series = given.series.map((s, index) => ({
      label: s.label,
      stroke: colour(index),
      // The first of two curves is broad, so that it shows below the other where they are one.
      width: index === 0 && given.series.filter((other) => !other.bars).length === 2 ? 4 : 1.8,
      value: short,
      ...(s.bars ? { marks: true, paths: () => null, points: { show: true, size: 8, width: 2 } } : { points: { show: false } }),
    }));
    const drawBars = (plot) => given.series.forEach((s, index) => {
      const context = plot.ctx;
      context.strokeStyle = colour(index);
      context.lineWidth = 1.5 * devicePixelRatio;
      for (const [time, low, high] of (plot.series[index + 1].show && s.bars) || []) {
        const [x, from, to] = [plot.valToPos(time, "x", true), plot.valToPos(low, "y", true), plot.valToPos(high, "y", true)];
        const cap = 4 * devicePixelRatio;
        const { left, width } = plot.bbox;
        if (x < left || x > left + width) continue;
        context.beginPath();
        context.moveTo(x, from); context.lineTo(x, to);
        for (const y of [from, to]) { context.moveTo(x - cap, y); context.lineTo(x + cap, y); }
        context.stroke();
      }
    });
    const range = (plot, least, largest) => uPlot.rangeNum(Math.min(least, ...ends), Math.max(largest, ...ends), 0.08, true);
    const options = {
      title: given.title,
      pxAlign: 0,
      width: host.clientWidth,
      height: 300,
      scales: { x: { time: false }, y: given.log ? { distr: 3 } : { range } },
      series: [{ label: "time (s)", value: short }, ...series],
      axes: [axis, { ...axis, size: 64, ...(given.log ? powers : {}) }],
      cursor: { dataIdx: nearest, sync: { key: "time" } },
      hooks: { draw: [drawBars] },
    };
    const data = given.tables.length > 1 ? uPlot.join(given.tables) : given.tables[0];
    const plot = new uPlot(options, data, host);
    new ResizeObserver(() => plot.setSize({ width: host.clientWidth, height: 300 })).observe(host);
  }

  function player(host) {
    const frames = [...host.querySelectorAll("figure")];
    const [button, slider] = host.querySelectorAll("button, input");
    let timer = 0;
    const show = (index) => {
      slider.value = index;
      frames.forEach((frame, at) => { frame.hidden = at !== index; });
    };
    const stop = () => { clearInterval(timer); timer = 0; button.textContent = "Play"; };
    slider.oninput = () => { stop(); show(+slider.value); };
    button.onclick = () => {
      if (timer) return stop();
      button.textContent = "Pause";
      timer = setInterval(() => show((+slider.value + 1) % frames.length), 400);
    };
    host.classList.add("playing");
    show(0);
  }

  document.querySelectorAll(".chart").forEach(chart);
  document.querySelectorAll(".player").forEach(player);
})();
