/* Stabilisation diagram: poles over model order, on the singular-value spectrum. */
(function (modal) {
  'use strict';

  const HOVER_PX = 14;
  const HEIGHT = 420;
  const DECADES = 9;

  function mark(context, key, x, y, size) {
    context.beginPath();
    if (key === 'harmonic') {
      context.moveTo(x, y - size * 1.3); context.lineTo(x + size * 1.3, y);
      context.lineTo(x, y + size * 1.3); context.lineTo(x - size * 1.3, y); context.closePath(); context.fill();
    } else if (key === 'candidate') {
      context.arc(x, y, size * 0.75, 0, 2 * Math.PI); context.stroke();
    } else if (key === 'unphysical') {
      context.moveTo(x - size, y - size); context.lineTo(x + size, y + size);
      context.moveTo(x + size, y - size); context.lineTo(x - size, y + size); context.stroke();
    } else {
      context.arc(x, y, key === 'kept' ? size : size * 0.7, 0, 2 * Math.PI); context.fill();
    }
  }

  function spectrumRange(values) {
    let low = Infinity, high = 0;
    values.forEach((column) => column.forEach((value) => {
      if (value > 0) { low = Math.min(low, value); high = Math.max(high, value); }
    }));
    if (high === 0) return [1e-3, 1];
    low = Math.max(low, high * Math.pow(10, -DECADES));
    const top = Math.pow(10, Math.ceil(Math.log10(high * 1.5)));
    return [Math.min(Math.pow(10, Math.floor(Math.log10(low))), top / 10), top];
  }

  /* Which poles a person picked: to begin with one of each mode; the file says which. */
  function pickPoles(data, redraw) {
    const poles = data.poles, picked = new Set();
    const bar = modal.element('div', 'picker');
    const say = modal.element('span', 'note');
    say.setAttribute('role', 'status');
    const save = modal.element('button', '', 'Save the choice'), again = modal.element('button', '', 'Automatic choice'), none = modal.element('button', '', 'None');
    [save, again, none].forEach((button) => { button.type = 'button'; });
    const ofMode = (id) => [...picked].filter((i) => poles.mode_id[i] === id);
    const begin = () => {
      picked.clear();
      data.lines.forEach((line) => {
        let best = -1;
        for (let i = 0; i < poles.mode_id.length; i++) {
          if (poles.frequency_hz[i] === null || line.harmonic) continue;
          const away = Math.abs(poles.frequency_hz[i] - line.frequency_hz);
          /* A mode picked by hand has no poles of its own: its pole has its very frequency. */
          const own = poles.mode_id[i] ? poles.mode_id[i] === line.id : away < 1e-5 * line.frequency_hz;
          if (own && (best < 0 || away < Math.abs(poles.frequency_hz[best] - line.frequency_hz))) best = i;
        }
        if (best >= 0) picked.add(best);
      });
    };
    const tell = () => {
      const kept = new Set([...picked].map((i) => poles.mode_id[i]).filter(Boolean)).size;
      const single = [...picked].filter((i) => !poles.mode_id[i]).length;
      say.textContent = kept + ' of the modes and ' + single + ' single poles are picked';
      redraw();
    };
    const toggle = (i) => {
      const same = poles.mode_id[i] ? ofMode(poles.mode_id[i]) : picked.has(i) ? [i] : [];
      if (same.length) same.forEach((each) => picked.delete(each)); else picked.add(i);
      tell();
    };
    const text = () => JSON.stringify({ ...data.pick, poles: [...picked].map((i) => ({
      model_order: poles.model_order[i], frequency_hz: poles.frequency_hz[i], damping_ratio: poles.damping_ratio[i],
    })).sort((a, b) => a.frequency_hz - b.frequency_hz) }, null, 1) + '\n';
    save.addEventListener('click', () => modal.save(new Blob([text()], { type: 'application/json' }), 'poles.json'));
    again.addEventListener('click', () => { begin(); tell(); });
    none.addEventListener('click', () => { picked.clear(); tell(); });
    bar.append(say, modal.element('span', 'spacer'), none, again, save);
    begin();
    say.textContent = picked.size + ' modes are picked';
    return { bar, picked, toggle, text };
  }

  /* `kept` holds what a reader chose, for the same chart with newer data. */
  modal.charts.stabilisation = function (host, data, kept = {}) {
    const poles = data.poles, spectrum = data.spectrum;
    if (!poles && !spectrum) { host.append(modal.element('p', 'note', 'No spectrum and no poles were recorded.')); return; }
    const columns = spectrum ? spectrum.singular_value : [];
    const groupOf = [];
    data.groups.forEach((group) => group.status.forEach((status) => { groupOf[status] = group.key; }));
    const visible = kept.visible = kept.visible || { kept: true, harmonic: true, candidate: true, unstable: true, unphysical: false };
    const chosen = kept.x;
    const count = poles ? poles.frequency_hz.length : 0;
    let xMax = 0;
    if (spectrum) xMax = spectrum.frequency_hz[spectrum.frequency_hz.length - 1];
    else poles.frequency_hz.forEach((f) => { if (f !== null) xMax = Math.max(xMax, f); });
    const topOrder = poles ? poles.model_order.reduce((a, b) => Math.max(a, b), 2) : 2;
    const grid = spectrum ? spectrum.frequency_hz : [0, xMax];
    const xMin = spectrum ? Math.min(grid[0], 0) : 0;
    const svRange = spectrumRange(columns);

    const tools = modal.element('div', 'tools');
    const reset = modal.element('button', '', 'Reset zoom');
    reset.type = 'button'; reset.hidden = true;

    function drawModes(u, context, ratio) {
      context.font = modal.font(11 * ratio);
      context.textAlign = 'center';
      let last = -Infinity;
      data.lines.forEach((mode) => {
        const x = u.valToPos(mode.frequency_hz, 'x', true);
        if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) return;
        const colour = modal.colour(mode.harmonic ? 'harmonic' : 'accent');
        context.globalAlpha = 0.45; context.strokeStyle = colour; context.lineWidth = ratio;
        context.setLineDash(mode.harmonic ? [3 * ratio, 3 * ratio] : []);
        context.beginPath(); context.moveTo(x, u.bbox.top); context.lineTo(x, u.bbox.top + u.bbox.height); context.stroke();
        context.setLineDash([]); context.globalAlpha = 1;
        if (x - last > 16 * ratio) {
          context.fillStyle = colour;
          context.fillText(mode.id ? String(mode.id) : '·', x, u.bbox.top - 5 * ratio);
          last = x;
        }
      });
    }

    function drawPoles(u) {
      const context = u.ctx, ratio = u.bbox.width / u.over.clientWidth;
      context.save();
      drawModes(u, context, ratio);
      context.beginPath(); context.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height); context.clip();
      /* What was kept is drawn last, on top. */
      data.groups.slice().reverse().forEach((group) => {
        if (!visible[group.key]) return;
        context.fillStyle = context.strokeStyle = modal.colour(group.key === 'kept' ? 'accent' : group.key);
        context.lineWidth = ratio;
        context.globalAlpha = group.key === 'kept' || group.key === 'harmonic' ? 1 : 0.6;
        for (let i = 0; i < count; i++) {
          if (groupOf[poles.status[i]] !== group.key || poles.frequency_hz[i] === null) continue;
          mark(context, group.key, u.valToPos(poles.frequency_hz[i], 'x', true),
            u.valToPos(poles.model_order[i], 'order', true), 2.9 * ratio);
        }
      });
      if (picker) picker.picked.forEach((i) => {
        context.globalAlpha = 1; context.lineWidth = 2 * ratio; context.strokeStyle = modal.colour('ink');
        context.beginPath();
        context.arc(u.valToPos(poles.frequency_hz[i], 'x', true), u.valToPos(poles.model_order[i], 'order', true), 6 * ratio, 0, 2 * Math.PI);
        context.stroke();
      });
      context.restore();
    }

    function poleAt(u, left, top) {
      let best = -1, nearest = HOVER_PX * HOVER_PX;
      for (let i = 0; i < count; i++) {
        if (!visible[groupOf[poles.status[i]]] || poles.frequency_hz[i] === null) continue;
        const dx = u.valToPos(poles.frequency_hz[i], 'x') - left, dy = u.valToPos(poles.model_order[i], 'order') - top;
        if (dx * dx + dy * dy < nearest) { nearest = dx * dx + dy * dy; best = i; }
      }
      return best;
    }

    function hover(u) {
      const { left, top } = u.cursor;
      if (left === undefined || left < 0 || top < 0) { modal.tooltip.hide(); return; }
      const best = poleAt(u, left, top);
      if (best < 0) { modal.tooltip.hide(); return; }
      const lines = [modal.significant(poles.frequency_hz[best], 5) + ' Hz', 'damping ' +
        modal.significant(100 * poles.damping_ratio[best], 3) + ' %', 'order ' + poles.model_order[best],
        data.status_words[poles.status[best]]];
      if (poles.mode_id[best]) lines.push('mode ' + poles.mode_id[best]);
      const box = u.over.getBoundingClientRect();
      modal.tooltip.show(lines.join('\n'), box.left + left, box.top + top);
    }

    const picker = data.pick && count ? pickPoles(data, () => plot.redraw(false)) : null;

    const narrow = () => host.clientWidth < 560;
    const options = {
      width: host.clientWidth, height: HEIGHT, legend: { show: false }, padding: [18, null, null, null],
      cursor: { points: { show: false }, y: false, drag: { x: true, y: false, setScale: true } },
      scales: {
        x: { time: false, range: (u, low, high) => (low === high ? [xMin, xMax] : [low, high]) },
        sv: { distr: 3, range: () => svRange },
        order: { range: () => [0, topOrder * 1.03] },
      },
      axes: [
        modal.axis({ label: 'Frequency [Hz]', labelSize: 24 }),
        modal.axis({ scale: 'sv', show: columns.length > 0, label: narrow() ? undefined : 'Singular value [(SI unit)²/Hz]', size: 56,
          values: (u, ticks) => ticks.map((tick) => (tick > 0 && Math.abs(Math.log10(tick) % 1) < 1e-9 ? power(tick) : '')),
          grid: { show: false } }),
        modal.axis({ scale: 'order', side: 1, show: count > 0, label: narrow() ? undefined : 'Model order', size: 36, grid: { show: false } }),
      ],
      series: [{}].concat(columns.map((_, index) => ({
        scale: 'sv', stroke: () => modal.colour(index === 0 ? 'spectrum' : 'faint'), width: index === 0 ? 1.4 : 0.8,
        alpha: index === 0 ? 1 : 0.65, points: { show: false },
      }))),
      hooks: {
        draw: [drawPoles], setCursor: [hover],
        setScale: [(u, key) => {
          if (key !== 'x') return;
          reset.hidden = Math.abs(u.scales.x.min - xMin) + Math.abs(u.scales.x.max - xMax) < 1e-9 * xMax;
          kept.x = reset.hidden ? null : { min: u.scales.x.min, max: u.scales.x.max };
        }],
      },
    };
    if (!columns.length) {
      /* uPlot wants one series to lay out the axes by. */
      options.series.push({ scale: 'order', show: true, stroke: 'transparent', points: { show: false } });
    }

    function power(tick) {
      const digits = '⁰¹²³⁴⁵⁶⁷⁸⁹', exponent = Math.round(Math.log10(tick));
      return '10' + (exponent < 0 ? '⁻' : '') + String(Math.abs(exponent)).split('').map((d) => digits[+d]).join('');
    }

    host.append(tools);
    const plot = new uPlot(options, [grid].concat(columns.length ? columns : [grid.map(() => 0)]), host);
    plot.root.setAttribute('role', 'img');
    plot.root.setAttribute('aria-label', 'Stabilisation diagram with ' + count + ' poles');
    plot.over.addEventListener('mouseleave', modal.tooltip.hide);
    const full = () => plot.setScale('x', { min: xMin, max: xMax });
    full();
    if (chosen) plot.setScale('x', chosen);
    reset.addEventListener('click', full);
    plot.over.addEventListener('dblclick', full);

    if (picker) {
      let down = null;
      plot.over.addEventListener('mousedown', (event) => { down = [event.clientX, event.clientY]; });
      plot.over.addEventListener('click', (event) => {
        /* A drag zooms. */
        if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 3) return;
        const box = plot.over.getBoundingClientRect();
        const best = poleAt(plot, event.clientX - box.left, event.clientY - box.top);
        if (best >= 0) picker.toggle(best);
      });
      host.append(picker.bar);
    }

    const swatches = [];
    data.groups.forEach((group) => {
      let members = 0;
      for (let i = 0; i < count; i++) if (groupOf[poles.status[i]] === group.key) members++;
      if (!members) return;
      const button = modal.element('button', 'legend');
      button.type = 'button';
      const swatch = modal.element('canvas');
      swatch.setAttribute('aria-hidden', 'true');
      button.append(swatch, group.label + ' (' + members + ')');
      button.setAttribute('aria-pressed', String(visible[group.key]));
      button.addEventListener('click', () => {
        visible[group.key] = !visible[group.key];
        button.setAttribute('aria-pressed', String(visible[group.key]));
        plot.redraw();
      });
      tools.append(button);
      swatches.push([swatch, group.key]);
    });
    tools.append(modal.element('span', 'spacer'), reset);

    const paintSwatches = () => swatches.forEach(([swatch, key]) => {
      const { context, width, height } = modal.context(swatch);
      context.fillStyle = context.strokeStyle = modal.colour(key === 'kept' ? 'accent' : key);
      mark(context, key, width / 2, height / 2, 3.6);
    });
    paintSwatches();
    modal.onRedraw(host, () => { plot.setSize({ width: host.clientWidth, height: modal.printing ? 320 : HEIGHT }); plot.redraw(false, true); paintSwatches(); }, () => plot.destroy());
  };
})(window.modal);
