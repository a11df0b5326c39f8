/* The connection, the choice of a screen, the pause. */
(function (modal) {
  'use strict';

  const MOST = { tracks: 500, logs: 300 };
  const SILENCE_MS = 15000;          /* three beats of the server */
  const AGAIN_MS = [300, 5000];      /* first and longest wait between attempts */
  const at = (id) => document.getElementById(id);
  const empty = () => ({ tracks: [], logs: [] });

  let told = empty();        /* what the cell said */
  let frozen = null;         /* what is shown while paused */
  let current = modal.screens[0];
  let drawn = false, asked = false;

  /* -- screens ---------------------------------------------------------------------------- */

  function draw() {
    asked = false;
    drawn = true;
    /* Where a reader is in a table stays where it is. */
    const main = at('screen'), boxes = () => [...main.querySelectorAll('.scroll')];
    const scrolled = boxes().map((box) => box.scrollLeft), focused = boxes().indexOf(document.activeElement);
    /* The page must not jump while the charts are made anew. */
    main.style.minHeight = main.offsetHeight + 'px';
    main.replaceChildren();
    modal.tooltip.hide();
    current.draw(main, frozen || told);
    main.style.minHeight = '';
    boxes().forEach((box, i) => { box.scrollLeft = scrolled[i] || 0; });
    if (focused >= 0 && boxes()[focused]) boxes()[focused].focus({ preventScroll: true });
  }

  /* At most once a frame, and only where one looks. */
  function ask() {
    if (asked) return;
    asked = true;
    requestAnimationFrame(draw);
  }

  function choose(screen, focus) {
    if (screen !== current || !drawn) {
      window.scrollTo(0, 0);
      at('screen').replaceChildren();
    }
    current = screen;
    tabs.forEach((tab, i) => {
      const chosen = modal.screens[i] === screen;
      tab.setAttribute('aria-selected', String(chosen));
      tab.tabIndex = chosen ? 0 : -1;
      if (chosen) {
        at('screen').setAttribute('aria-labelledby', tab.id);
        tab.scrollIntoView({ block: 'nearest', inline: 'nearest' });
        if (focus) tab.focus();
      }
    });
    history.replaceState(null, '', '#' + screen.key);
    ask();
  }

  const tabs = modal.screens.map((screen, i) => {
    const tab = modal.element('button', '', screen.title);
    tab.type = 'button'; tab.id = 'tab-' + screen.key;
    tab.setAttribute('role', 'tab');
    tab.setAttribute('aria-controls', 'screen');
    tab.addEventListener('click', () => choose(screen));
    tab.addEventListener('keydown', (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      choose(modal.screens[(i + step + modal.screens.length) % modal.screens.length], true);
    });
    at('screens').append(tab);
    return tab;
  });

  const named = () => modal.screens.find((screen) => '#' + screen.key === window.location.hash);
  window.addEventListener('hashchange', () => { if (named()) choose(named()); });

  function pause() {
    frozen = frozen ? null : Object.assign({}, told, { tracks: told.tracks.slice(), logs: told.logs.slice() });
    at('pause').textContent = frozen ? 'Go on' : 'Pause page';
    at('pause').setAttribute('aria-pressed', String(Boolean(frozen)));
    label();
    ask();
  }
  at('pause').addEventListener('click', pause);

  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const screen = modal.screens[Number(event.key) - 1];
    if (screen) choose(screen);
    else if (event.key === 'p' || event.key === 'P') pause();
    else if (event.key === 't' || event.key === 'T') at('theme').click();
  });

  /* -- what the cell says ----------------------------------------------------------------- */

  function take(message) {
    const { kind, data } = message;
    if (kind === 'tracks' || kind === 'logs') told[kind] = data;
    else if (kind === 'track' || kind === 'log') {
      const rows = told[kind + 's'];
      rows.push(data);
      if (rows.length > MOST[kind + 's']) rows.shift();
    } else told[kind] = data;
    if (!frozen && current.of.includes(kind)) ask();
    label();
  }

  /* -- connection ------------------------------------------------------------------------- */

  let socket = null, heard = 0, wait = AGAIN_MS[0];

  function connect() {
    const mine = new WebSocket((window.location.protocol === 'https:' ? 'wss://' : 'ws://') + window.location.host + '/live');
    let first = true;
    socket = mine;
    heard = Date.now();
    mine.addEventListener('message', (event) => {
      if (socket !== mine) return;
      /* Everything comes anew; until it does, what was known stays on the screen. */
      if (first) { told = empty(); first = false; wait = AGAIN_MS[0]; ask(); }
      heard = Date.now();
      take(JSON.parse(event.data));
    });
    mine.addEventListener('close', () => lost(mine));
  }

  function lost(mine) {
    if (socket !== mine) return;
    socket = null;
    label();
    setTimeout(connect, wait);
    wait = Math.min(2 * wait, AGAIN_MS[1]);
  }

  function age(seconds) {
    if (seconds < 60) return Math.round(seconds) + ' s';
    return seconds < 5400 ? Math.round(seconds / 60) + ' min' : (seconds / 3600).toFixed(1) + ' h';
  }

  function label() {
    const live = Boolean(socket) && socket.readyState === WebSocket.OPEN;
    const shown = frozen || told;
    document.documentElement.dataset.link = frozen ? 'paused' : live ? 'live' : 'lost';
    at('link').textContent = frozen ? 'paused' : live ? 'live' : 'connection lost, trying again';
    const newest = shown.window;
    let words = '';
    if (newest) words = '· window ' + newest.index + ', ' + newest.n_modes + (newest.n_modes === 1 ? ' mode' : ' modes') + ', ' + age(Math.max(0, Date.now() / 1000 - newest.received_s)) + ' ago';
    if (frozen && told.window && (!newest || told.window.index !== newest.index)) words += ' · now window ' + told.window.index;
    at('newest').textContent = words;
  }

  setInterval(() => {
    if (socket && socket.readyState === WebSocket.OPEN && Date.now() - heard > SILENCE_MS) {
      const silent = socket;
      lost(silent);
      silent.close();
    }
    label();
  }, 1000);

  choose(named() || current);
  connect();
})(window.modal);
