/* The screens: what each is drawn from, and how. */
(function (modal) {
  'use strict';

  const note = (text) => modal.element('p', 'note', text);
  const WAITING = 'No result yet: the first comes after one window of data.';

  /* Put a chart into the page first: it takes its size from there. */
  function chart(host, title, name, data, kept, caption) {
    const box = modal.element('div', 'chart');
    host.append(modal.section(title, box));
    modal.charts[name](box, data, kept);
    if (caption) box.after(modal.element('p', 'caption', caption));
  }

  function health(host, shown) {
    if (!shown.window) host.append(note(WAITING));
    else {
      const kind = shown.window.identifiable ? '' : 'bad';
      host.append(modal.section('Data of the newest window', ...modal.sentences(shown.window.sentences, kind), modal.entries(shown.window.facts)));
      host.append(modal.section('Channels', modal.table(shown.window.channels)));
    }
    if (shown.checks) host.append(modal.section('Checks of the nodes', modal.table(shown.checks)));
  }

  const AROUND = 1.5;
  const kept = { spectrum: {}, poles: {} };

  /* At first where the modes are, a reader's choice afterwards: a sensor's band is often twenty times as wide. */
  function diagram(host, title, which, data, caption) {
    const choice = kept[which], highest = Math.max(0, ...data.lines.map((mode) => mode.frequency_hz));
    if (choice.x === undefined && highest) choice.x = { min: 0, max: AROUND * highest };
    chart(host, title + ', window ' + data.index, 'stabilisation', data, choice, caption + ' Drag to zoom, double click for all.');
  }

  function spectrum(host, shown) {
    if (!shown.diagram) { host.append(note(WAITING)); return; }
    diagram(host, 'Singular values of the responses', 'spectrum', Object.assign({}, shown.diagram, { poles: null }),
      'Lines: modes by their ids, dashed those of machines and drives.');
  }

  function poles(host, shown) {
    if (!shown.diagram) { host.append(note(WAITING)); return; }
    diagram(host, 'Poles over the model order', 'poles', shown.diagram, 'Point at a pole to be told why it was taken or not.');
    host.append(modal.section('Why', modal.table(shown.diagram.reasons)));
  }

  function modes(host, shown) {
    if (!shown.window) { host.append(note(WAITING)); return; }
    host.append(modal.section('Modes of window ' + shown.window.index, modal.table(shown.window.modes)));
    if (!shown.window.identifiable) host.append(...modal.sentences(shown.window.sentences, 'bad'));
    if (!shown.shapes) return;
    chart(host, 'Mode shapes', 'mode_shapes', shown.shapes);
    const panels = modal.element('div', 'panels');
    panels.append(...shown.shapes.modes.map(complexity));
    host.append(modal.section('Complexity of the shapes', panels),
      modal.element('p', 'caption', 'Every line is one sensor, its length the amplitude and its direction the phase. The points of a real mode lie on one line.'));
  }

  const SIDE = 150, RADIUS = 58;

  /* The points of one shape in the complex plane, the largest on the circle. */
  function complexity(mode) {
    const figure = modal.element('figure'), middle = SIDE / 2;
    const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
    const draw = (tag, kind, values) => {
      const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
      made.setAttribute('class', kind);
      Object.entries(values).forEach(([name, value]) => made.setAttribute(name, value));
      svg.append(made);
    };
    svg.setAttribute('viewBox', '0 0 ' + SIDE + ' ' + SIDE);
    svg.setAttribute('role', 'img');
    svg.setAttribute('aria-label', 'Shape of mode ' + mode.id + ' in the complex plane');
    draw('circle', 'rim', { cx: middle, cy: middle, r: RADIUS });
    draw('line', 'grid', { x1: middle - RADIUS, y1: middle, x2: middle + RADIUS, y2: middle });
    draw('line', 'grid', { x1: middle, y1: middle - RADIUS, x2: middle, y2: middle + RADIUS });
    const points = mode.shape_real.map((real, i) => [real, mode.shape_imag[i]]).filter(([real, imag]) => real !== null && imag !== null);
    const largest = Math.max(1e-300, ...points.map(([real, imag]) => Math.hypot(real, imag)));
    points.forEach(([real, imag]) => {
      const x = middle + RADIUS * real / largest, y = middle - RADIUS * imag / largest;
      draw('line', 'point', { x1: middle, y1: middle, x2: x, y2: y });
      draw('circle', 'dot', { cx: x, cy: y, r: 2 });
    });
    figure.append(svg, modal.element('figcaption', '', (mode.id ? mode.id + ': ' : '') + mode.frequency));
    return figure;
  }

  function mac(host, shown) {
    if (!shown.window) { host.append(note(WAITING)); return; }
    const maps = shown.window.mac.map((table) => { const made = modal.table(table); made.classList.add('mac'); return made; });
    host.append(modal.section('MAC', ...(maps.length ? maps : [note('No modes to compare.')])));
    host.append(modal.element('p', 'caption', '1: the same shape; 0: orthogonal. Between windows the diagonal tells whether a shape stays.'));
  }

  /* Times of the samples, from the first window on; the band of a strip is that of the newest value. */
  function tracksData(all) {
    /* A recording that is played again begins a new trend. */
    const again = all.findLastIndex((row, i) => i > 0 && row.start_s < all[i - 1].start_s);
    const rows = all.slice(Math.max(0, again));
    const origin = rows[0].start_s, newest = new Map();
    const windows = rows.map((row) => Object.assign({}, row, { start_s: row.start_s - origin, end_s: row.end_s - origin }));
    windows.forEach((row) => row.modes.forEach((mode) => { if (mode.id) newest.set(mode.id, mode); }));
    const strips = [...newest.values()].sort((a, b) => a.frequency_hz - b.frequency_hz);
    return { windows, strips: strips.map((mode) => Object.assign({ true_frequency_hz: null, true_damping_ratio: null }, mode)) };
  }

  const SAME_POSE_DEG = 3;
  let poseChosen = '';

  /* Windows by pose, as the first of each has it; a pose is held within three degrees in every joint. */
  function posesOf(rows) {
    const found = [];
    rows.forEach((row) => {
      if (!row.pose) return;
      const near = (other) => other.angles.length === row.pose.angles.length && other.angles.every((angle, i) => Math.abs(angle - row.pose.angles[i]) <= SAME_POSE_DEG);
      const known = found.find((pose) => near(pose.first));
      if (known) known.rows.push(row); else found.push({ first: row.pose, rows: [row] });
    });
    return found;
  }

  function poseChoice(rows, redraw) {
    const poses = posesOf(rows), label = modal.element('label', '', 'Pose '), choice = modal.element('select');
    if (poses.length < 2) return null;
    const offer = (value, words) => { const option = modal.element('option', '', words); option.value = value; choice.append(option); };
    offer('', 'all ' + poses.length);
    poses.forEach((pose) => offer(pose.first.words, pose.first.words + ' (' + pose.rows.length + ')'));
    choice.value = poses.some((pose) => pose.first.words === poseChosen) ? poseChosen : '';
    choice.addEventListener('change', () => { poseChosen = choice.value; redraw(); });
    label.append(choice);
    const one = poses.find((pose) => pose.first.words === choice.value);
    return { label, rows: one ? one.rows : rows };
  }

  function trends(host, shown) {
    const told = shown.alarms;
    if (told && told.history) {
      host.append(modal.section('Alarms', ...(told.alarms.length ? modal.sentences(told.alarms, 'bad') : [note('No mode changed beyond chance.')])));
    }
    if (!shown.tracks.length) { host.append(note(WAITING)); return; }
    const choice = poseChoice(shown.tracks, () => { host.replaceChildren(); trends(host, shown); });
    if (choice) host.append(choice.label);
    const data = tracksData(choice ? choice.rows : shown.tracks), count = data.windows.length;
    chart(host, 'Frequencies and damping over ' + count + (count === 1 ? ' window' : ' windows'), 'tracks', data, undefined,
      'Bars: 2σ of each window. Line and band of a strip: newest value ± 2σ.');
  }

  function cell(host, shown) {
    if (!shown.bridge) host.append(modal.section('Bridge', note('No bridge has told its state.')));
    else {
      const bar = modal.element('progress');
      bar.value = shown.bridge.progress;
      bar.setAttribute('aria-label', 'Part of the plan that was played');
      const state = modal.entries(shown.bridge.entries);
      if (shown.bridge.bad) state.classList.add('bad');
      host.append(modal.section('Bridge', bar, state));
    }
    if (!shown.plan) host.append(modal.section('Plan', note('No plan has been made.')));
    else host.append(modal.section('Plan', modal.entries(shown.plan.entries), modal.element('h3', '', 'Modes it is expected to excite'), modal.table(shown.plan.modes)));
  }

  function log(host, shown) {
    const rows = shown.logs.slice().reverse().map((line) => ({
      kind: '', cells: [[new Date(1000 * line.time_s).toLocaleTimeString([], { hour12: false }), '', 1], [line.words, ('free ' + line.kind).trim(), 1]],
    }));
    const data = { label: 'Run log', caption: '', empty: 'Nothing has happened yet.', headings: [['Time', '', 1], ['What happened', '', 1]], rows };
    host.append(modal.section('Run log', modal.table(data)));
  }

  modal.screens = [
    { key: 'health', title: 'Data health', of: ['window', 'checks'], draw: health },
    { key: 'spectrum', title: 'Spectrum', of: ['diagram'], draw: spectrum },
    { key: 'poles', title: 'Poles', of: ['diagram'], draw: poles },
    { key: 'modes', title: 'Modes', of: ['window', 'shapes'], draw: modes },
    { key: 'mac', title: 'MAC', of: ['window'], draw: mac },
    { key: 'trends', title: 'Trends', of: ['track', 'tracks', 'alarms'], draw: trends },
    { key: 'cell', title: 'Cell', of: ['bridge', 'plan'], draw: cell },
    { key: 'log', title: 'Log', of: ['log', 'logs'], draw: log },
  ];
})(window.modal);
