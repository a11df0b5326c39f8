/* Spectra of single channels: measured and synthesised, and coherence with one of them. */
(function (modal) {
  'use strict';

  const DECADES = 7;

  function decades(columns) {
    let high = 0, low = Infinity;
    columns.forEach((column) => column.forEach((value) => { if (value > 0) { high = Math.max(high, value); low = Math.min(low, value); } }));
    if (!high) return [1e-3, 1];
    return [Math.max(low, high * Math.pow(10, -DECADES)) / 1.5, high * 1.5];
  }

  modal.charts.channel_spectra = function (host, data) {
    if (!data) { host.append(modal.element('p', 'note', 'The stretches between gaps are too short for spectra.')); return; }
    const bar = modal.element('div', 'tools'), label = modal.element('label', '', 'Channel '), choice = modal.element('select');
    data.names.forEach((name, index) => { const option = modal.element('option', '', name); option.value = index; choice.append(option); });
    label.append(choice);
    const reset = modal.element('button', '', 'Reset zoom');
    reset.type = 'button'; reset.hidden = true;
    bar.append(modal.element('span', 'spacer'), reset);
    /* Paper says which channel it is, too. */
    host.append(label, bar);
    const grid = data.frequency_hz, low = grid[0], high = grid[grid.length - 1];
    const plots = [];
    let busy = false;

    const show = (u, index) => {
      const box = u.over.getBoundingClientRect(), row = u.cursor.idx, left = u.cursor.left;
      if (row === null || row === undefined || left < 0) { modal.tooltip.hide(); return; }
      const said = [modal.significant(grid[row], 5) + ' Hz'];
      u.series.slice(1).forEach((series, at) => said.push(series.label + ' ' + modal.significant(u.data[at + 1][row], 3)));
      modal.tooltip.show(said.join('\n'), box.left + left, box.top + u.cursor.top);
    };
    const zoomed = (u, key) => {
      if (key !== 'x' || busy) return;
      busy = true;
      plots.forEach((other) => { if (other !== u) other.setScale('x', { min: u.scales.x.min, max: u.scales.x.max }); });
      busy = false;
      reset.hidden = u.scales.x.min <= low && u.scales.x.max >= high;
    };
    const line = (name, colour, width) => ({ label: name, scale: 'y', stroke: () => modal.colour(colour), width, points: { show: false } });
    const options = (height, name, series, log) => ({
      width: host.clientWidth, height, legend: { show: false }, padding: [8, 12, null, null],
      cursor: { points: { show: false }, y: false, drag: { x: true, y: false, setScale: true } },
      scales: { x: { time: false, range: (u, a, b) => (a === b ? [low, high] : [a, b]) }, y: log ? { distr: 3, range: (u) => decades(u.data.slice(1)) } : { range: () => [0, 1] } },
      axes: [modal.axis({ label: 'Frequency [Hz]', labelSize: 24 }),
        (log ? modal.logAxis : modal.axis)({ scale: 'y', label: name, size: 62 })],
      series: [{}].concat(series), hooks: { setScale: [zoomed], setCursor: [show] },
    });
    plots.push(new uPlot(options(300, 'PSD [(SI unit)²/Hz]', [line('measured', 'spectrum', 1.2), line('synthesised', 'accent', 1.8)], true),
      [grid, data.psd[0], data.synthesised[0]], host));
    plots.push(new uPlot(options(170, 'Coherence', [line('coherence', 'spectrum', 1.2)], false), [grid, data.coherence[0]], host));
    plots.forEach((plot, at) => {
      plot.root.setAttribute('role', 'img');
      plot.root.setAttribute('aria-label', at ? 'Coherence with ' + data.reference : 'Measured and synthesised spectrum');
      plot.over.addEventListener('mouseleave', modal.tooltip.hide);
      plot.over.addEventListener('dblclick', full);
    });
    function full() { plots[0].setScale('x', { min: low, max: high }); }
    full();
    choice.addEventListener('change', () => {
      const index = Number(choice.value), range = { min: plots[0].scales.x.min, max: plots[0].scales.x.max };
      plots[0].setData([grid, data.psd[index], data.synthesised[index]], false);
      plots[1].setData([grid, data.coherence[index]], false);
      plots[0].setScale('x', range);
      plots.forEach((plot) => plot.redraw(true, true));
    });
    reset.addEventListener('click', full);
    modal.onRedraw(host, () => plots.forEach((plot, at) => { plot.setSize({ width: host.clientWidth, height: at ? 170 : 300 }); plot.redraw(false, true); }), () => plots.forEach((plot) => plot.destroy()));
  };
})(window.modal);
