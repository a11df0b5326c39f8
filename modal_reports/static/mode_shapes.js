/* Mode shapes on the arm: a turning wireframe per mode, or one bar per channel without geometry; a second result may lie over each. */
(function (modal) {
  'use strict';

  const PERIOD_MS = 1800, FRAMES = 30;
  const EXAGGERATION = 0.22;   /* largest motion over the size of the arm */
  const view = { yaw: -0.75, pitch: 0.32 };
  let wanted = !window.matchMedia('(prefers-reduced-motion: reduce)').matches;   /* whether shapes move */
  let phase = 0;
  const enlarged = new Set();   /* ids: a page that is drawn anew with newer shapes shows them as before */

  function frame(points) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    points.forEach((point) => point.forEach((value, axis) => {
      low[axis] = Math.min(low[axis], value); high[axis] = Math.max(high[axis], value);
    }));
    const centre = low.map((value, axis) => (value + high[axis]) / 2);
    const radius = Math.max(1e-9, ...points.map((point) => Math.hypot(...point.map((value, axis) => value - centre[axis]))));
    return { centre, radius, floor: low[2] };
  }

  function projector(box, width, height) {
    const scale = 0.5 * Math.min(width, height) / (box.radius * (1 + EXAGGERATION));
    const cy = Math.cos(view.yaw), sy = Math.sin(view.yaw), cp = Math.cos(view.pitch), sp = Math.sin(view.pitch);
    return (point) => {
      const x = point[0] - box.centre[0], y = point[1] - box.centre[1], z = point[2] - box.centre[2];
      const right = cy * x - sy * y, away = sy * x + cy * y;
      return [width / 2 + scale * right, height / 2 - scale * (cp * z + sp * away)];
    };
  }

  function path(context, project, points, line) {
    context.beginPath();
    line.forEach((index, at) => {
      const [x, y] = project(points[index]);
      if (at) context.lineTo(x, y); else context.moveTo(x, y);
    });
    context.stroke();
  }

  function floor(context, project, box) {
    const span = box.radius * 0.7, step = span / 2;
    context.strokeStyle = modal.colour('rule'); context.lineWidth = 1;
    for (let i = -2; i <= 2; i++) {
      path(context, project, [[box.centre[0] + i * step, box.centre[1] - span, box.floor], [box.centre[0] + i * step, box.centre[1] + span, box.floor]], [0, 1]);
      path(context, project, [[box.centre[0] - span, box.centre[1] + i * step, box.floor], [box.centre[0] + span, box.centre[1] + i * step, box.floor]], [0, 1]);
    }
  }

  function drawArm(canvas, geometry, box, mode, phase) {
    const { context, width, height } = modal.context(canvas);
    const project = projector(box, width, height);
    const c = Math.cos(phase), s = Math.sin(phase);
    const at = (angleC, angleS, shape = mode) => geometry.points_m.map((point, i) => point.map((value, axis) =>
      value + mode.scale * ((shape.moved_real[i][axis] || 0) * angleC - (shape.moved_imag[i][axis] || 0) * angleS)));
    context.lineCap = context.lineJoin = 'round';
    floor(context, project, box);
    context.strokeStyle = modal.colour('faint'); context.lineWidth = 1.4; context.setLineDash([3, 4]);
    geometry.lines.forEach((line) => path(context, project, geometry.points_m, line));
    context.setLineDash([]);
    /* The far side of the swing, so that a still picture tells the direction. */
    if (!mode.other) {
      const opposite = at(-c, -s);
      context.strokeStyle = modal.colour('accent-soft'); context.lineWidth = 2.5;
      geometry.lines.forEach((line) => path(context, project, opposite, line));
    }
    const points = at(c, s);
    context.strokeStyle = colourOf(mode); context.lineWidth = 4;
    geometry.lines.forEach((line) => path(context, project, points, line));
    if (mode.other) {
      const beside = at(c, s, mode.other);
      context.strokeStyle = modal.colour('after'); context.lineWidth = 2;
      geometry.lines.forEach((line) => path(context, project, beside, line));
    }
    geometry.sensors.forEach((index) => {
      const [x, y] = project(points[index]);
      context.beginPath(); context.arc(x, y, 4, 0, 2 * Math.PI);
      context.fillStyle = modal.colour('paper'); context.fill();
      context.strokeStyle = modal.colour('ink'); context.lineWidth = 1.5; context.stroke();
    });
  }

  const colourOf = (mode) => modal.colour(mode.other ? 'before' : mode.harmonic ? 'harmonic' : 'accent');

  function drawBars(canvas, names, mode, phase) {
    const { context, width, height } = modal.context(canvas);
    const c = Math.cos(phase), s = Math.sin(phase), count = mode.shape_real.length;
    const valueOf = (shape, i) => (shape.shape_real[i] || 0) * c - (shape.shape_imag[i] || 0) * s;
    const sizeOf = (shape, i) => Math.hypot(shape.shape_real[i] || 0, shape.shape_imag[i] || 0);
    const shapes = mode.other ? [mode, mode.other] : [mode];
    /* A shape of its own reaches 1; one that is fitted to another may reach further. */
    const most = Math.max(1, ...shapes.flatMap((shape) => shape.shape_real.map((_, i) => sizeOf(shape, i))));
    const few = count <= 12, label = few ? Math.min(110, width * 0.4) : 0, pad = 14;
    context.font = modal.font(11); context.textBaseline = 'middle';
    const along = few ? height - 2 * pad : width - 2 * pad, step = Math.min(34, along / count);
    const start = pad + (along - step * count) / 2;
    const half = few ? (width - label - 2 * pad) / 2 : (height - 2 * pad) / 2, reach = half / most;
    const zero = few ? label + pad + half : height / 2;
    context.strokeStyle = modal.colour('faint'); context.lineWidth = 1; context.beginPath();
    if (few) { context.moveTo(zero, start); context.lineTo(zero, start + step * count); } else { context.moveTo(start, zero); context.lineTo(start + step * count, zero); }
    context.stroke();
    mode.shape_real.forEach((_, i) => {
      const centre = start + (i + 0.5) * step, all = Math.max(1, Math.min(mode.other ? 20 : 12, step * 0.6)), thick = all / shapes.length;
      shapes.forEach((shape, at) => {
        const size = sizeOf(shape, i), value = valueOf(shape, i), begin = centre - all / 2 + at * thick;
        context.fillStyle = modal.colour('rule');
        if (few) context.fillRect(zero - size * reach, begin, 2 * size * reach, thick); else context.fillRect(begin, zero - size * reach, thick, 2 * size * reach);
        context.fillStyle = at ? modal.colour('after') : colourOf(mode);
        if (few) context.fillRect(Math.min(zero, zero + value * reach), begin, Math.abs(value) * reach, thick); else context.fillRect(begin, Math.min(zero, zero - value * reach), thick, Math.abs(value) * reach);
      });
      if (few) {
        let name = names[i] || '';
        while (name.length > 1 && context.measureText(name).width > label - 8) name = name.slice(0, name.endsWith('…') ? -2 : -1) + '…';
        context.fillStyle = modal.colour('soft'); context.fillText(name, pad / 2, centre);
        if (mode.shape_real[i] === null) context.fillText('not seen', zero + 4, centre);
      }
    });
  }

  modal.charts.mode_shapes = function (host, data) {
    const modes = data.modes;
    if (!modes.length) { host.append(modal.element('p', 'note', 'No shapes to draw.')); return; }
    const tools = modal.element('div', 'tools'), cardHost = modal.element('div', 'cards');
    host.append(tools, cardHost);
    const geometry = data.geometry;
    const box = geometry && frame(geometry.points_m);
    const shown = new Set();
    const cards = modes.map((mode) => {
      const solid = Boolean(geometry && mode.moved_real);
      const card = modal.element('figure', solid ? 'card' : 'card flat'), canvas = modal.element('canvas'), caption = modal.element('figcaption');
      caption.append(modal.element('b', '', mode.id ? 'Mode ' + mode.id : 'Mode'),
        modal.element('span', mode.other ? 'before' : '', mode.frequency),
        modal.element('span', mode.other ? 'before' : '', mode.damping));
      if (mode.other) caption.append(modal.element('span', 'after', mode.other.frequency), modal.element('span', 'after', mode.other.damping));
      if (mode.harmonic) caption.append(modal.element('span', '', 'harmonic'));
      canvas.setAttribute('role', 'img');
      canvas.setAttribute('aria-label', 'Shape of the mode at ' + mode.frequency);
      card.append(canvas, caption); cardHost.append(card);
      if (solid) {
        let largest = 1e-300;
        mode.moved_real.forEach((row, i) => { largest = Math.max(largest, Math.hypot(...row, ...mode.moved_imag[i])); });
        mode.scale = EXAGGERATION * box.radius / largest;
        turnable(canvas);
      }
      const drawn = (phase) => (solid ? drawArm(canvas, geometry, box, mode, phase) : drawBars(canvas, data.channel_names, mode, phase));
      caption.append(modal.element('span', 'spacer'), ...enlarging(card, canvas, mode, drawn));
      return { canvas, draw: (phase) => (solid ? drawArm(canvas, geometry, box, mode, phase) : drawBars(canvas, data.channel_names, mode, phase)) };
    });

    let playing = false, request = 0, before = 0;
    const paint = (all) => cards.forEach((card) => { if (all || shown.has(card.canvas)) card.draw(phase); });
    const step = (now) => {
      if (!host.isConnected) return;
      phase += 2 * Math.PI * Math.min(now - before, 100) / PERIOD_MS;
      before = now;
      paint(false);
      request = requestAnimationFrame(step);
    };
    const play = () => {
      playing = wanted;
      button.textContent = playing ? 'Pause' : 'Play';
      button.setAttribute('aria-pressed', String(playing));
      cancelAnimationFrame(request);
      if (playing) { before = performance.now(); request = requestAnimationFrame(step); }
    };
    const button = modal.element('button');
    button.type = 'button';
    if (!document.getElementById('play')) button.id = 'play';
    button.addEventListener('click', () => { wanted = !wanted; play(); });
    tools.append(button);

    const observer = new IntersectionObserver((entries) => {
      entries.forEach((entry) => (entry.isIntersecting ? shown.add(entry.target) : shown.delete(entry.target)));
      if (!playing) paint(false);
    });
    cards.forEach((card) => observer.observe(card.canvas));
    modal.onRedraw(host, () => { if (modal.printing) { phase = 0; } paint(true); }, () => observer.disconnect());

    /* One shape as wide as the page, and its motion as a file. */
    function enlarging(card, canvas, mode, drawn) {
      const larger = modal.element('button', 'small', 'Enlarge'), save = modal.element('button', 'small', 'Save GIF');
      larger.type = save.type = 'button'; save.hidden = true;
      const show = () => {
        const large = enlarged.has(mode.id);
        card.classList.toggle('large', large);
        larger.textContent = large ? 'Reduce' : 'Enlarge';
        save.hidden = !large;
      };
      larger.addEventListener('click', () => {
        if (!enlarged.delete(mode.id)) enlarged.add(mode.id);
        show();
        drawn(phase);
      });
      show();
      save.addEventListener('click', () => { modal.save(film(canvas, drawn), 'mode_' + (mode.id || mode.frequency.split(' ')[0]) + '.gif'); drawn(phase); });
      return [save, larger];
    }

    function film(canvas, drawn) {
      const frames = [];
      for (let i = 0; i < FRAMES; i++) {
        drawn(2 * Math.PI * i / FRAMES);
        const still = document.createElement('canvas'), context = still.getContext('2d', { willReadFrequently: true });
        still.width = canvas.clientWidth; still.height = canvas.clientHeight;
        context.fillStyle = modal.colour('paper');
        context.fillRect(0, 0, still.width, still.height);
        context.drawImage(canvas, 0, 0, still.width, still.height);
        frames.push(context.getImageData(0, 0, still.width, still.height).data);
      }
      return modal.gif(frames, canvas.clientWidth, canvas.clientHeight, Math.round(PERIOD_MS / 10 / FRAMES));
    }

    function turnable(canvas) {
      canvas.tabIndex = 0;
      canvas.addEventListener('pointerdown', (event) => { canvas.setPointerCapture(event.pointerId); });
      canvas.addEventListener('pointermove', (event) => {
        if (!canvas.hasPointerCapture(event.pointerId)) return;
        turn(event.movementX * 0.01, event.movementY * 0.01);
      });
      canvas.addEventListener('keydown', (event) => {
        const moves = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
        if (moves) { event.preventDefault(); turn(...moves); }
      });
    }
    function turn(yaw, pitch) {
      view.yaw += yaw;
      view.pitch = Math.max(-1.5, Math.min(1.5, view.pitch + pitch));
      if (!playing) paint(false);
    }

    paint(true);
    play();
  };
})(window.modal);
