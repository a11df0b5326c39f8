/* What every chart shares: colours of the theme, sharp canvases, text. Names are only ever shown as text. */
(function (modal) {
  'use strict';

  /* Each takes the element to draw in and its data. */
  modal.charts = {};

  /* Asking for a style has the page laid out anew, so each colour is asked for once per look of the page. */
  let colours = new Map();
  modal.colour = (name) => {
    if (!colours.has(name)) colours.set(name, getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim());
    return colours.get(name);
  };

  modal.element = (tag, className, text) => {
    const made = document.createElement(tag);
    if (className) made.className = className;
    if (text !== undefined) made.textContent = text;
    return made;
  };

  /* Charts redraw themselves when the theme, the width or the medium changes, as long as their element is on the page. */
  let charts = [];
  modal.onRedraw = (host, redraw, end) => {
    charts = charts.filter((chart) => {
      if (!chart.host.isConnected && chart.end) chart.end();
      return chart.host.isConnected;
    });
    charts.push({ host, redraw, end });
  };
  modal.redraw = () => {
    colours = new Map();
    charts.forEach((chart) => { if (chart.host.isConnected) chart.redraw(); });
  };

  /* Give a canvas as many pixels as it covers on screen; return its context in CSS pixels. */
  modal.context = (canvas) => {
    const ratio = Math.max(window.devicePixelRatio || 1, modal.printing ? 3 : 1);
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext('2d');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    return { context, width, height };
  };

  modal.significant = (value, digits) => {
    if (value === null || value === undefined) return '–';
    return Number(value.toPrecision(digits || 4)).toString();
  };

  modal.tooltip = {
    show(text, x, y) {
      const box = document.getElementById('tooltip');
      box.textContent = text;
      box.hidden = false;
      const left = Math.min(x + 14, document.documentElement.clientWidth - box.offsetWidth - 8);
      box.style.left = Math.max(4, left) + window.scrollX + 'px';
      box.style.top = y + 14 + window.scrollY + 'px';
    },
    hide() { document.getElementById('tooltip').hidden = true; },
  };

  modal.font = (size) => size + 'px system-ui, -apple-system, "Segoe UI", Roboto, Arial, "DejaVu Sans", sans-serif';

  /* Places of a logarithmic axis. uPlot's own never end where an axis begins between powers of ten. */
  const WIDE_DECADES = 3;
  function decadePlaces(low, high) {
    const first = Math.floor(Math.log10(low)), last = Math.ceil(Math.log10(high)), places = [];
    const parts = last - first > WIDE_DECADES ? [1] : [1, 2, 3, 4, 5, 6, 7, 8, 9];
    for (let decade = first; decade <= last; decade++) parts.forEach((part) => {
      const place = Number(part + 'e' + decade);
      if (place >= low && place <= high) places.push(place);
    });
    return places;
  }
  const isPower = (tick) => Math.abs(Math.log10(tick) - Math.round(Math.log10(tick))) < 1e-9;
  modal.logAxis = (extra) => modal.axis(Object.assign({
    splits: (u, axis, low, high) => decadePlaces(low, high),
    filter: (u, places) => places,
    /* Without two powers of ten in sight every place is named. */
    values: (u, places) => places.map((place) => (isPower(place) || places.filter(isPower).length < 2 ? place.toExponential(0) : '')),
  }, extra));

  modal.axis = (extra) => Object.assign({
    stroke: () => modal.colour('soft'), font: modal.font(12), labelFont: modal.font(12), labelSize: 20, labelGap: 2,
    grid: { stroke: () => modal.colour('rule'), width: 1 }, ticks: { show: false }, gap: 6,
  }, extra);
})(window.modal = window.modal || {});
