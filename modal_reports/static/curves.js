/* Curves of one number over another: axes with units, hover and zoom along both. */
(function (modal) {
  'use strict';

  const HEIGHT = 300, SMALL = 230;
  const HOVER_PX = 24;
  const DECADES = 7, LEAST_DECADES = 1.5;

  function spanOf(values) {
    let low = Infinity, high = -Infinity;
    values.forEach((value) => { if (value !== null) { low = Math.min(low, value); high = Math.max(high, value); } });
    return low <= high ? [low, high] : [0, 1];
  }

  function ranges(data) {
    const x = spanOf(data.traces.flatMap((trace) => trace.x)), y = spanOf(data.traces.flatMap((trace) => trace.y).concat(data.level === null ? [] : [data.level]));
    const aside = (x[1] - x[0]) * 0.01 || 1;
    if (data.logarithmic) {
      const top = y[1] * 1.4, low = Math.max(y[0], y[1] * Math.pow(10, -DECADES)) / 1.4;
      return { x: [x[0], x[1]], y: [Math.min(low, top * Math.pow(10, -LEAST_DECADES)), top] };
    }
    const room = (y[1] - y[0]) * 0.05 || 1;
    return { x: [x[0] - aside, x[1] + aside], y: [y[0] - room, y[1] + room] };
  }

  const DASHES = { before: [5, 3] };
  const WIDTHS = { measured: 3.6 };

  function drawTraces(u, data) {
    const context = u.ctx, ratio = u.bbox.width / u.over.clientWidth;
    const X = (value) => u.valToPos(value, 'x', true), Y = (value) => u.valToPos(value, 'y', true);
    context.save();
    context.beginPath(); context.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height); context.clip();
    context.lineJoin = 'round';
    if (data.level !== null) {
      context.strokeStyle = modal.colour('soft'); context.lineWidth = ratio; context.setLineDash([4 * ratio, 3 * ratio]);
      context.beginPath(); context.moveTo(u.bbox.left, Y(data.level)); context.lineTo(u.bbox.left + u.bbox.width, Y(data.level)); context.stroke();
    }
    data.traces.forEach((trace) => {
      context.strokeStyle = modal.colour(trace.kind);
      context.lineWidth = (WIDTHS[trace.kind] || 1.6) * ratio;
      context.globalAlpha = trace.kind === 'measured' ? 0.4 : 1;
      context.setLineDash((DASHES[trace.kind] || []).map((value) => value * ratio));
      context.beginPath();
      let pen = false;
      trace.x.forEach((x, i) => {
        if (x === null || trace.y[i] === null) { pen = false; return; }
        if (pen) context.lineTo(X(x), Y(trace.y[i])); else context.moveTo(X(x), Y(trace.y[i]));
        pen = true;
      });
      context.stroke();
    });
    context.restore();
  }

  /* The point next to the pointer, and what every curve says there. */
  function words(u, data) {
    const { left, top } = u.cursor;
    if (left === undefined || left < 0 || top < 0) return null;
    let best = null, least = HOVER_PX * HOVER_PX;
    data.traces.forEach((trace) => trace.x.forEach((x, i) => {
      if (x === null || trace.y[i] === null) return;
      const dx = u.valToPos(x, 'x') - left, dy = u.valToPos(trace.y[i], 'y') - top;
      if (dx * dx + dy * dy < least) { least = dx * dx + dy * dy; best = { trace, i }; }
    }));
    if (!best) return null;
    const said = [(modal.significant(best.trace.x[best.i], 4) + ' ' + data.across.unit).trim()];
    const valued = (trace, i) => trace.name + ': ' + (modal.significant(trace.y[i], 3) + ' ' + data.up.unit).trim();
    data.traces.forEach((trace) => {
      /* Curves over one grid are compared; others say the nearest point alone. */
      if (trace === best.trace) said.push(valued(trace, best.i));
      else if (trace.x.length === best.trace.x.length && trace.x[best.i] === best.trace.x[best.i] && trace.y[best.i] !== null && trace.name !== best.trace.name) said.push(valued(trace, best.i));
    });
    return said.join('\n');
  }

  modal.charts.curves = function (host, data) {
    const head = modal.element('div', 'curves-head'), reset = modal.element('button', 'small', 'Reset zoom');
    reset.type = 'button'; reset.hidden = true;
    head.append(modal.element('b', '', data.title), modal.element('span', 'spacer'), reset);
    host.append(head);
    const whole = ranges(data), height = host.classList.contains('lesser') ? SMALL : HEIGHT;
    const within = (key) => (u, a, b) => (a === b || a === null ? whole[key] : [a, b]);
    const full = () => plot.batch(() => { plot.setScale('x', { min: whole.x[0], max: whole.x[1] }); plot.setScale('y', { min: whole.y[0], max: whole.y[1] }); });
    const up = (data.logarithmic ? modal.logAxis : modal.axis)({ label: data.up.words, size: 58 });
    const plot = new uPlot({
      width: host.clientWidth, height, legend: { show: false }, padding: [8, 14, null, null],
      cursor: { points: { show: false }, drag: { x: true, y: true, uni: 20, setScale: true } },
      scales: { x: { time: false, range: within('x') }, y: { distr: data.logarithmic ? 3 : 1, range: within('y') } },
      axes: [modal.axis({ label: data.across.words, size: 36 }), up],
      series: [{}, { stroke: 'transparent', points: { show: false } }],
      hooks: {
        draw: [(u) => drawTraces(u, data)],
        setCursor: [(u) => {
          const text = words(u, data), box = u.over.getBoundingClientRect();
          if (text) modal.tooltip.show(text, box.left + u.cursor.left, box.top + u.cursor.top); else modal.tooltip.hide();
        }],
        setScale: [(u) => {
          const near = (key) => Math.abs(u.scales[key].min - whole[key][0]) + Math.abs(u.scales[key].max - whole[key][1]) <= 1e-9 * (whole[key][1] - whole[key][0]);
          reset.hidden = near('x') && near('y');
        }],
      },
    }, [whole.x, whole.y], host);
    full();
    plot.root.setAttribute('role', 'img');
    plot.root.setAttribute('aria-label', data.title + ': ' + data.up.words + ' over ' + data.across.words);
    plot.over.addEventListener('dblclick', full);
    plot.over.addEventListener('mouseleave', modal.tooltip.hide);
    reset.addEventListener('click', full);
    const fit = () => { if (host.clientWidth) { plot.setSize({ width: host.clientWidth, height }); plot.redraw(false, true); } };
    /* What is folded has no width until it is opened. */
    const fold = host.closest('details');
    if (fold) fold.addEventListener('toggle', fit);
    modal.onRedraw(host, fit, () => plot.destroy());
  };
})(window.modal);
