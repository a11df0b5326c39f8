/* Spectra of two results over each other, with the modes of both. */
(function (modal) {
  'use strict';

  const HEIGHT = 340;
  const SIGMAS = 2;
  const DECADES = 8;
  const HOVER_PX = 8;
  const COLOURS = ['before', 'after'];

  /* Both spectra have frequencies of their own. */
  const joined = (states) => uPlot.join(states.map((state) => [state.frequency_hz, state.singular_value]));

  function decades(columns) {
    let high = 0, low = Infinity;
    columns.forEach((column) => column.forEach((value) => { if (value > 0) { high = Math.max(high, value); low = Math.min(low, value); } }));
    return [Math.max(low, high * Math.pow(10, -DECADES)) / 1.5, high * 1.5];
  }

  /* Modes of the first are named above the picture, those of the second just inside. */
  function drawModes(u, states) {
    const context = u.ctx, ratio = u.bbox.width / u.over.clientWidth, top = u.bbox.top, foot = u.bbox.top + u.bbox.height;
    context.save();
    context.font = modal.font(11 * ratio); context.textAlign = 'center';
    states.forEach((state, index) => {
      let last = -Infinity;
      context.strokeStyle = context.fillStyle = modal.colour(COLOURS[index]);
      state.modes.forEach((mode) => {
        const x = u.valToPos(mode.frequency_hz, 'x', true), spread = SIGMAS * (mode.std_hz || 0);
        if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) return;
        const left = Math.max(u.bbox.left, u.valToPos(mode.frequency_hz - spread, 'x', true));
        const right = Math.min(u.bbox.left + u.bbox.width, u.valToPos(mode.frequency_hz + spread, 'x', true));
        context.globalAlpha = 0.18; context.fillRect(left, top, right - left, u.bbox.height);
        context.globalAlpha = 0.9; context.lineWidth = 1.2 * ratio; context.setLineDash(index ? [4 * ratio, 3 * ratio] : []);
        context.beginPath(); context.moveTo(x, top); context.lineTo(x, foot); context.stroke();
        context.setLineDash([]); context.globalAlpha = 1;
        if (mode.id && x - last > 16 * ratio) { context.fillText(String(mode.id), x, index ? top - 4 * ratio : top - 16 * ratio); last = x; }
      });
    });
    context.restore();
  }

  function words(u, states) {
    const left = u.cursor.left;
    if (left === undefined || left < 0) return null;
    const hz = u.posToVal(left, 'x'), said = [modal.significant(hz, 5) + ' Hz'];
    states.forEach((state) => {
      let near = null, least = HOVER_PX;
      state.modes.forEach((mode) => {
        const away = Math.abs(u.valToPos(mode.frequency_hz, 'x') - left);
        if (away < least) { least = away; near = mode; }
      });
      let at = 0;
      state.frequency_hz.forEach((value, index) => { if (Math.abs(value - hz) < Math.abs(state.frequency_hz[at] - hz)) at = index; });
      if (state.frequency_hz.length) said.push(state.name + ': ' + modal.significant(state.singular_value[at], 3) + ' (SI unit)²/Hz');
      if (near) said.push((near.id ? 'mode ' + near.id + ' of ' : 'mode of ') + state.name + ': ' + near.words.replace('\n', ', '));
    });
    return said.join('\n');
  }

  modal.charts.compared_spectra = function (host, data) {
    if (!data) { host.append(modal.element('p', 'note', 'No spectra were kept.')); return; }
    const states = data.states, legend = modal.element('p', 'key'), bar = modal.element('div', 'tools');
    states.forEach((state, index) => legend.append(modal.element('span', COLOURS[index], (index ? 'then: ' : 'first: ') + state.name + (state.frequency_hz.length ? '' : ' (no spectrum kept)')), ' '));
    const reset = modal.element('button', '', 'Reset zoom');
    reset.type = 'button'; reset.hidden = true;
    bar.append(modal.element('span', 'spacer'), reset);
    host.append(legend, bar);
    const columns = joined(states), ends = columns[0], low = ends[0], high = ends[ends.length - 1];
    const range = decades(columns.slice(1));
    const full = () => plot.setScale('x', { min: low, max: high });
    const plot = new uPlot({
      width: host.clientWidth, height: HEIGHT, legend: { show: false }, padding: [30, 14, null, null],
      cursor: { points: { show: false }, y: false, drag: { x: true, y: false, setScale: true } },
      scales: { x: { time: false, range: (u, a, b) => (a === b ? [low, high] : [a, b]) }, y: { distr: 3, range: () => range } },
      axes: [modal.axis({ label: 'Frequency [Hz]', labelSize: 24 }), modal.logAxis({ label: host.clientWidth < 560 ? undefined : 'Singular value [(SI unit)²/Hz]', size: 62 })],
      series: [{}].concat(states.map((state, index) => ({ label: state.name, stroke: () => modal.colour(COLOURS[index]), width: 1.4, spanGaps: true, points: { show: false } }))),
      hooks: {
        draw: [(u) => drawModes(u, states)],
        setCursor: [(u) => {
          const text = words(u, states), box = u.over.getBoundingClientRect();
          if (text) modal.tooltip.show(text, box.left + u.cursor.left, box.top + u.cursor.top); else modal.tooltip.hide();
        }],
        setScale: [(u, key) => { if (key === 'x') reset.hidden = u.scales.x.min <= low && u.scales.x.max >= high; }],
      },
    }, columns, host);
    full();
    plot.root.setAttribute('role', 'img');
    plot.root.setAttribute('aria-label', 'Spectra of ' + states.map((state) => state.name).join(' and '));
    plot.over.addEventListener('dblclick', full);
    plot.over.addEventListener('mouseleave', modal.tooltip.hide);
    reset.addEventListener('click', full);
    modal.onRedraw(host, () => { plot.setSize({ width: host.clientWidth, height: HEIGHT }); plot.redraw(false, true); }, () => plot.destroy());
  };
})(window.modal);
