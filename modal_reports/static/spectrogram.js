/* Spectrogram over time, and over the speed of a joint (Campbell diagram), with the modes of the windows. */
(function (modal) {
  'use strict';

  const HEIGHT = 380;
  const SIGMAS = 2;
  const HEAT_STEPS = 8;
  const UNKNOWN = 255, STEPS = 254;
  const ORDERS = [1, 2, 3, 4, 6, 12];
  const HOVER_PX = 14;

  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const parts = (name) => { const value = modal.colour(name); return [1, 3, 5].map((at) => parseInt(value.slice(at, at + 2), 16)); };

  /* Colours between those of the heat scale, for every level. */
  function ramp() {
    const stops = Array.from({ length: HEAT_STEPS }, (_, step) => parts('heat-' + step));
    return Array.from({ length: STEPS + 1 }, (_, level) => {
      const at = level / STEPS * (HEAT_STEPS - 1), low = Math.min(Math.floor(at), HEAT_STEPS - 2), share = at - low;
      return stops[low].map((value, part) => Math.round(value + share * (stops[low + 1][part] - value)));
    });
  }

  /* A picture of one pixel per column and frequency, the lowest frequency at its foot. */
  function pictureOf(view, data) {
    const canvas = modal.element('canvas'), n = view.n_columns, rows = data.n_rows;
    canvas.width = n; canvas.height = rows;
    const context = canvas.getContext('2d'), image = context.createImageData(n, rows), colours = ramp();
    for (let column = 0; column < n; column++) for (let row = 0; row < rows; row++) {
      const level = view.level[column * rows + row];
      if (level === UNKNOWN) continue;
      const at = 4 * ((rows - 1 - row) * n + column), colour = colours[level];
      image.data[at] = colour[0]; image.data[at + 1] = colour[1]; image.data[at + 2] = colour[2]; image.data[at + 3] = 255;
    }
    context.putImageData(image, 0, 0);
    return canvas;
  }

  /* One view per abscissa: where each mark stands, and what the columns are. */
  function viewsOf(data) {
    const over = (spectra, name, unit, place) => ({
      ...spectra, name, unit, level: bytes(spectra.levels), end: spectra.step * spectra.n_columns, turns: spectra.turns || [],
      marks: data.marks.map((mark) => ({ mark, at: place(mark.window) })).filter((each) => each.at.every((value) => value !== null)),
    });
    const time = over(data.time, 'Time from the start', 's', (row) => {
      const [start, end] = data.windows[row];
      return [(start + end) / 2, (start + end) / 2, (start + end) / 2];
    });
    return data.joints.map((joint) => over(joint, 'Speed of ' + joint.name, '°/s', (row) => joint.windows[row])).concat([time]);
  }

  function drawPicture(u, view, data) {
    const context = u.ctx, high = data.low_hz + data.row_hz * data.n_rows;
    const left = u.valToPos(0, 'x', true), right = u.valToPos(view.end, 'x', true);
    const top = u.valToPos(high, 'y', true), bottom = u.valToPos(data.low_hz, 'y', true);
    context.save();
    context.beginPath(); context.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height); context.clip();
    context.imageSmoothingEnabled = false;
    context.drawImage(view.picture, left, top, right - left, bottom - top);
    context.restore();
  }

  /* What turns with the joint: its speed in degrees a second, times turns of the motor, times the order. */
  function drawOrders(u, view) {
    const context = u.ctx, ratio = u.bbox.width / u.over.clientWidth, low = u.scales.x.min, high = u.scales.x.max;
    context.strokeStyle = context.fillStyle = modal.colour('ink');
    context.lineWidth = ratio; context.font = modal.font(11 * ratio); context.textAlign = 'right';
    const written = [];
    view.turns.forEach((turns) => ORDERS.forEach((order) => {
      const slope = order * turns / 360;
      context.setLineDash([4 * ratio, 4 * ratio]); context.globalAlpha = 0.75;
      context.beginPath();
      context.moveTo(u.valToPos(low, 'x', true), u.valToPos(slope * low, 'y', true));
      context.lineTo(u.valToPos(high, 'x', true), u.valToPos(slope * high, 'y', true));
      context.stroke(); context.setLineDash([]); context.globalAlpha = 1;
      const end = Math.min(high, u.scales.y.max / slope);
      const x = u.valToPos(end, 'x', true) - 3 * ratio, y = Math.max(u.valToPos(slope * end, 'y', true), u.bbox.top) + 12 * ratio;
      const inside = y < u.bbox.top + u.bbox.height - 2 * ratio;
      if (!inside || written.some((other) => Math.hypot(other.x - x, other.y - y) < 13 * ratio)) return;
      written.push({ x, y });
      label(context, order + '×', x, y, ratio);
    }));
    context.textAlign = 'left';
  }

  /* Words that can be read on any colour. */
  function label(context, text, x, y, ratio) {
    context.save();
    context.lineWidth = 3 * ratio; context.strokeStyle = modal.colour('paper'); context.lineJoin = 'round';
    context.strokeText(text, x, y); context.fillText(text, x, y);
    context.restore();
  }

  function drawMarks(u, view) {
    const context = u.ctx, ratio = u.bbox.width / u.over.clientWidth;
    const X = (value) => u.valToPos(value, 'x', true), Y = (value) => u.valToPos(value, 'y', true);
    const last = new Map();
    view.marks.forEach(({ mark, at }) => {
      const x = X(at[0]), y = Y(mark.frequency_hz), spread = SIGMAS * (mark.std_hz || 0);
      const strokes = () => {
        context.beginPath();
        context.moveTo(X(at[1]), y); context.lineTo(X(at[2]), y);
        context.moveTo(x, Y(mark.frequency_hz - spread)); context.lineTo(x, Y(mark.frequency_hz + spread));
        context.stroke();
      };
      context.strokeStyle = modal.colour('paper'); context.lineWidth = 3 * ratio; context.globalAlpha = 0.6; strokes();
      context.strokeStyle = context.fillStyle = modal.colour(mark.harmonic ? 'harmonic' : 'accent');
      context.lineWidth = 1.2 * ratio; context.globalAlpha = 0.8; strokes(); context.globalAlpha = 1;
      context.beginPath();
      const size = 3.4 * ratio;
      if (mark.harmonic) { context.moveTo(x, y - size * 1.4); context.lineTo(x + size * 1.4, y); context.lineTo(x, y + size * 1.4); context.lineTo(x - size * 1.4, y); context.closePath(); } else context.arc(x, y, size, 0, 2 * Math.PI);
      context.fill();
      context.strokeStyle = modal.colour('paper'); context.lineWidth = ratio; context.stroke();
      if (mark.id && !mark.harmonic && (!last.has(mark.id) || last.get(mark.id).x < x)) last.set(mark.id, { x, y });
    });
    context.font = modal.font(11 * ratio); context.fillStyle = modal.colour('ink');
    const written = [];
    last.forEach(({ x, y }, id) => {
      if (written.some((other) => Math.abs(other - y) < 11 * ratio)) return;
      label(context, String(id), x + 8 * ratio, y + 4 * ratio, ratio);
      written.push(y);
    });
  }

  function words(u, view, data) {
    const { left, top } = u.cursor;
    if (left === undefined || left < 0 || top < 0) return null;
    let best = null, least = HOVER_PX * HOVER_PX;
    view.marks.forEach(({ mark, at }) => {
      const dx = u.valToPos(at[0], 'x') - left, dy = u.valToPos(mark.frequency_hz, 'y') - top;
      if (dx * dx + dy * dy < least) { least = dx * dx + dy * dy; best = mark; }
    });
    if (best) return best.words + '\nwindow ' + best.window;
    const x = u.posToVal(left, 'x'), hz = u.posToVal(top, 'y');
    const column = Math.floor(x / view.step), row = Math.floor((hz - data.low_hz) / data.row_hz);
    if (column < 0 || column >= view.n_columns || row < 0 || row >= data.n_rows) return null;
    const level = view.level[column * data.n_rows + row];
    const said = [modal.significant(hz, 4) + ' Hz', modal.significant(x, 3) + ' ' + view.unit];
    if (level === UNKNOWN) said.push('not measured');
    else {
      const psd = modal.significant(view.top * Math.pow(10, view.faint_db * (level / STEPS - 1) / 10), 2);
      said.push((level ? '' : 'at most ') + psd + ' (SI unit)²/Hz');
    }
    return said.join('\n');
  }

  /* The colours and what they are. */
  function scaleOf(data) {
    const figure = modal.element('span', 'heat-scale'), canvas = modal.element('canvas');
    figure.append(modal.element('span', '', '−' + data.time.faint_db + ' dB'), canvas, modal.element('span', '', 'strongest'));
    const paint = () => {
      canvas.width = STEPS + 1; canvas.height = 1;
      const context = canvas.getContext('2d'), image = context.createImageData(STEPS + 1, 1);
      ramp().forEach((colour, level) => image.data.set([...colour, 255], 4 * level));
      context.putImageData(image, 0, 0);
    };
    return { figure, paint };
  }

  modal.charts.spectrogram = function (host, data) {
    if (!data) { host.append(modal.element('p', 'note', 'The windows are too short for a spectrogram.')); return; }
    const views = viewsOf(data), choice = modal.element('select'), pick = modal.element('label', 'spectrogram-over', 'Over ');
    /* The joint that moved most is shown first. */
    const fastest = (view) => (view.unit === 's' ? 0 : view.end);
    views.sort((one, other) => fastest(other) - fastest(one));
    views.forEach((view, index) => { const option = modal.element('option', '', view.name); option.value = index; choice.append(option); });
    pick.append(choice);
    const bar = modal.element('div', 'tools'), reset = modal.element('button', '', 'Reset zoom'), scale = scaleOf(data);
    reset.type = 'button'; reset.hidden = true;
    bar.append(modal.element('span', 'spacer'), reset);
    host.append(pick, scale.figure, bar);
    const low = data.low_hz, high = data.low_hz + data.row_hz * data.n_rows;
    let view = views[0], plot = null;

    const full = () => plot.batch(() => { plot.setScale('x', { min: 0, max: view.end }); plot.setScale('y', { min: low, max: high }); });
    const isWhole = (u) => u.scales.x.min <= 0 && u.scales.x.max >= view.end && u.scales.y.min <= low && u.scales.y.max >= high;
    const say = (u) => {
      const found = words(u, view, data), box = u.over.getBoundingClientRect();
      if (found) modal.tooltip.show(found, box.left + u.cursor.left, box.top + u.cursor.top); else modal.tooltip.hide();
    };
    const paint = () => { views.forEach((each) => { each.picture = null; }); view.picture = pictureOf(view, data); scale.paint(); };
    const draw = (u) => {
      const context = u.ctx;
      context.save();
      context.beginPath(); context.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height); context.clip();
      drawOrders(u, view); drawMarks(u, view);
      context.restore();
    };
    const build = () => {
      if (plot) plot.destroy();
      paint();
      plot = new uPlot({
        width: host.clientWidth, height: modal.printing ? 300 : HEIGHT, legend: { show: false }, padding: [8, 14, null, null],
        cursor: { points: { show: false }, drag: { x: true, y: true, uni: 20, setScale: true } },
        scales: { x: { time: false, range: (u, a, b) => (a === b || a === null ? [0, view.end] : [a, b]) }, y: { range: (u, a, b) => (a === b || a === null ? [low, high] : [a, b]) } },
        axes: [modal.axis({ label: view.name + ' [' + view.unit + ']', labelSize: 24, grid: { show: false } }), modal.axis({ label: host.clientWidth < 560 ? undefined : 'Frequency [Hz]', size: 52, grid: { show: false } })],
        series: [{}, { stroke: 'transparent', points: { show: false } }],
        hooks: { drawClear: [(u) => drawPicture(u, view, data)], draw: [draw], setCursor: [say], setScale: [(u) => { reset.hidden = isWhole(u); }] },
      }, [[0, view.end], [low, high]], host);
      full();
      plot.root.setAttribute('role', 'img');
      plot.root.setAttribute('aria-label', 'Spectra: ' + view.name);
      plot.over.addEventListener('dblclick', full);
      plot.over.addEventListener('mouseleave', modal.tooltip.hide);
    };
    build();
    choice.addEventListener('change', () => { view = views[Number(choice.value)]; build(); });
    reset.addEventListener('click', full);
    modal.onRedraw(host, () => { paint(); plot.setSize({ width: host.clientWidth, height: modal.printing ? 300 : HEIGHT }); plot.redraw(false, true); }, () => plot.destroy());
  };
})(window.modal);
