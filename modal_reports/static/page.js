/* Theme, width and paper: charts follow them. */
(function (modal) {
  'use strict';
  const at = (id) => document.getElementById(id);
  const root = document.documentElement;
  const prefersDark = window.matchMedia('(prefers-color-scheme: dark)');
  const asked = /^#theme=(light|dark)$/.exec(window.location.hash);
  const isDark = () => (root.dataset.theme ? root.dataset.theme === 'dark' : prefersDark.matches);
  if (asked) root.dataset.theme = asked[1];

  const button = at('theme');
  const label = () => { button.textContent = isDark() ? 'Light' : 'Dark'; };
  button.hidden = false;
  button.addEventListener('click', () => { root.dataset.theme = isDark() ? 'light' : 'dark'; label(); modal.redraw(); });
  prefersDark.addEventListener('change', () => { label(); modal.redraw(); });
  label();

  let width = root.clientWidth;
  window.addEventListener('resize', () => {
    if (root.clientWidth === width) return;
    width = root.clientWidth;
    modal.redraw();
  });

  /* Paper is white and narrow, whatever the screen was. */
  let before;
  window.addEventListener('beforeprint', () => {
    before = root.dataset.theme;
    root.dataset.theme = 'light';
    document.body.style.maxWidth = '680px';
    modal.printing = true;
    modal.redraw();
  });
  window.addEventListener('afterprint', () => {
    if (before) root.dataset.theme = before; else delete root.dataset.theme;
    document.body.style.maxWidth = '';
    modal.printing = false;
    modal.redraw();
  });
})(window.modal);
