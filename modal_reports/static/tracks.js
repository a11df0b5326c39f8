/* Modes over windows: all frequencies in one chart, and a strip per mode for its small changes. */
(function (modal) {
  'use strict';

  const SIGMAS = 2;
  const HEIGHT = 300;

  function tracksOf(windows) {
    const tracks = new Map();
    windows.forEach((window, row) => window.modes.forEach((mode) => {
      const key = mode.id || 0;
      if (!tracks.has(key)) tracks.set(key, []);
      tracks.get(key).push({ row, time: (window.start_s + window.end_s) / 2, mode });
    }));
    return tracks;
  }

  function errorBar(context, x, top, bottom, cap) {
    context.beginPath();
    context.moveTo(x, top); context.lineTo(x, bottom);
    context.moveTo(x - cap, top); context.lineTo(x + cap, top);
    context.moveTo(x - cap, bottom); context.lineTo(x + cap, bottom);
    context.stroke();
  }

  function drawTracks(u, tracks) {
    const context = u.ctx, ratio = u.bbox.width / u.over.clientWidth;
    const X = (value) => u.valToPos(value, 'x', true), Y = (value) => u.valToPos(value, 'y', true);
    context.save();
    context.beginPath(); context.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height); context.clip();
    context.font = modal.font(11 * ratio);
    const labelled = [];
    tracks.forEach((track, id) => {
      const colour = modal.colour(track[0].mode.harmonic ? 'harmonic' : 'accent');
      context.strokeStyle = context.fillStyle = colour;
      context.lineWidth = ratio; context.globalAlpha = 0.5; context.beginPath();
      track.forEach((point, at) => {
        const joined = id && at && point.row === track[at - 1].row + 1;
        if (joined) context.lineTo(X(point.time), Y(point.mode.frequency_hz)); else context.moveTo(X(point.time), Y(point.mode.frequency_hz));
      });
      context.stroke(); context.globalAlpha = 1; context.lineWidth = 1.3 * ratio;
      track.forEach((point) => {
        const x = X(point.time), f = point.mode.frequency_hz, s = SIGMAS * (point.mode.frequency_std_hz || 0);
        if (s > 0) errorBar(context, x, Y(f + s), Y(f - s), 2.5 * ratio);
        context.beginPath(); context.arc(x, Y(f), 2.4 * ratio, 0, 2 * Math.PI); context.fill();
      });
      const end = track[track.length - 1];
      const y = Y(end.mode.frequency_hz) + 4 * ratio;
      if (id && labelled.every((other) => Math.abs(other - y) > 11 * ratio)) {
        context.fillText(String(id), X(end.time) + 7 * ratio, y);
        labelled.push(y);
      }
    });
    context.restore();
  }

  function nearest(u, tracks) {
    const { left, top } = u.cursor;
    let best = null, least = 16 * 16;
    if (left === undefined || left < 0) return null;
    tracks.forEach((track, id) => track.forEach((point) => {
      const dx = u.valToPos(point.time, 'x') - left, dy = u.valToPos(point.mode.frequency_hz, 'y') - top;
      if (dx * dx + dy * dy < least) { least = dx * dx + dy * dy; best = { point, id }; }
    }));
    return best;
  }

  function overview(host, data) {
    const windows = data.windows, tracks = tracksOf(windows);
    if (!tracks.size) { host.append(modal.element('p', 'note', 'No mode was found in any window.')); return; }
    const end = windows[windows.length - 1].end_s;
    let top = 0;
    tracks.forEach((track) => track.forEach((point) => {
      top = Math.max(top, point.mode.frequency_hz + SIGMAS * (point.mode.frequency_std_hz || 0));
    }));
    const hover = (u) => {
      const found = nearest(u, tracks);
      if (!found) { modal.tooltip.hide(); return; }
      const mode = found.point.mode, box = u.over.getBoundingClientRect();
      modal.tooltip.show([found.id ? 'mode ' + found.id : 'not tracked',
        mode.frequency, 'damping ' + mode.damping,
        'window ' + windows[found.point.row].index].join('\n'), box.left + u.cursor.left, box.top + u.cursor.top);
    };
    const full = { x: [0, end], y: [0, top * 1.08] };
    const plot = new uPlot({
      width: host.clientWidth, height: HEIGHT, legend: { show: false },
      cursor: { points: { show: false }, x: false, y: false, drag: { x: true, y: true, uni: 20 } },
      scales: {
        x: { time: false, range: (u, low, high) => (low === high ? full.x : [low, high]) },
        y: { range: (u, low, high) => (low === null || low === high ? full.y : [low, high]) },
      },
      axes: [modal.axis({ label: 'Time from the start [s]', labelSize: 24 }), modal.axis({ label: host.clientWidth < 560 ? undefined : 'Frequency [Hz]', size: 52 })],
      series: [{}, { stroke: 'transparent', points: { show: false } }],
      hooks: { draw: [(u) => drawTracks(u, tracks)], setCursor: [hover] },
    }, [[0, end], [0, top]], host);
    const reset = () => plot.batch(() => { plot.setScale('x', { min: full.x[0], max: full.x[1] }); plot.setScale('y', { min: full.y[0], max: full.y[1] }); });
    reset();
    plot.over.addEventListener('dblclick', reset);
    plot.over.addEventListener('mouseleave', modal.tooltip.hide);
    plot.root.setAttribute('role', 'img');
    plot.root.setAttribute('aria-label', 'Frequencies over ' + windows.length + ' windows');
    modal.onRedraw(host, () => { plot.setSize({ width: host.clientWidth, height: HEIGHT }); plot.redraw(false, true); }, () => plot.destroy());
  }

  function drawStrip(canvas, strip) {
    const { context, width, height } = modal.context(canvas);
    const left = 2, right = width - 58, pad = 8;
    let low = Infinity, high = -Infinity;
    const take = (value, spread) => { if (value !== null) { low = Math.min(low, value - spread); high = Math.max(high, value + spread); } };
    strip.points.forEach((point) => take(point.value, SIGMAS * (point.std || 0)));
    take(strip.whole, SIGMAS * (strip.wholeStd || 0));
    if (strip.truth !== null) take(strip.truth, 0);
    const least = Math.abs(strip.whole) * 1e-4 || 1e-9;
    if (high - low < least) { high += least / 2; low -= least / 2; }
    const X = (time) => left + 6 + (right - left - 12) * time / strip.end, Y = (value) => height - pad - (height - 2 * pad) * (value - low) / (high - low);
    context.fillStyle = modal.colour('panel'); context.fillRect(left, 0, right - left, height);
    if (strip.wholeStd > 0) {
      context.fillStyle = modal.colour('accent-soft'); context.globalAlpha = 0.55;
      context.fillRect(left, Y(strip.whole + SIGMAS * strip.wholeStd), right - left, Y(strip.whole - SIGMAS * strip.wholeStd) - Y(strip.whole + SIGMAS * strip.wholeStd));
      context.globalAlpha = 1;
    }
    const level = (value, colour, dash) => {
      context.strokeStyle = colour; context.setLineDash(dash); context.lineWidth = 1;
      context.beginPath(); context.moveTo(left, Y(value)); context.lineTo(right, Y(value)); context.stroke(); context.setLineDash([]);
    };
    level(strip.whole, modal.colour('accent'), []);
    if (strip.truth !== null) level(strip.truth, modal.colour('ink'), [4, 3]);
    context.strokeStyle = context.fillStyle = modal.colour('ink'); context.lineWidth = 1.1;
    const crowded = strip.points.length > 60;
    strip.points.forEach((point) => {
      const x = X(point.time), s = SIGMAS * (point.std || 0);
      if (s > 0) errorBar(context, x, Y(point.value + s), Y(point.value - s), crowded ? 0 : 2);
      context.beginPath(); context.arc(x, Y(point.value), crowded ? 1.3 : 2.2, 0, 2 * Math.PI); context.fill();
    });
    context.font = modal.font(10.5); context.fillStyle = modal.colour('soft'); context.textBaseline = 'middle';
    const decimals = Math.min(5, Math.max(0, 1 - Math.floor(Math.log10(high - low))));
    context.fillText(high.toFixed(decimals), right + 6, pad); context.fillText(low.toFixed(decimals), right + 6, height - pad);
  }

  function strips(host, data) {
    const tracks = tracksOf(data.windows), end = data.windows[data.windows.length - 1].end_s;
    const drawn = [];
    data.strips.forEach((mode) => {
      const track = mode.id ? tracks.get(mode.id) : null;
      if (!track) return;
      const kinds = [[mode.frequency, 'frequency_hz', 'frequency_std_hz', 'true_frequency_hz', 1], [mode.damping + ' damping', 'damping_ratio', 'damping_ratio_std', 'true_damping_ratio', 100]];
      kinds.forEach(([text, key, std, truth, factor]) => {
        const times = (value) => (value === null ? null : factor * value);
        const strip = {
          end, whole: times(mode[key]), wholeStd: times(mode[std]), truth: times(mode[truth]),
          points: track.map((point) => ({ time: point.time, value: times(point.mode[key]), std: times(point.mode[std]) })),
        };
        const figure = modal.element('figure', 'strip'), canvas = modal.element('canvas');
        figure.append(modal.element('figcaption', '', 'Mode ' + mode.id + ' · ' + text), canvas);
        host.append(figure);
        drawn.push(() => drawStrip(canvas, strip));
      });
    });
    const paint = () => drawn.forEach((draw) => draw());
    paint();
    modal.onRedraw(host, paint);
  }

  modal.charts.tracks = function (host, data) {
    const chart = modal.element('div', 'chart'), below = modal.element('div', 'strips');
    host.append(chart, below);
    overview(chart, data);
    strips(below, data);
  };
})(window.modal);
