/* Put the charts into a page that holds their data. */
(function (modal) {
  'use strict';
  const data = JSON.parse(document.getElementById('report-data').textContent);
  /* Of several charts of one kind each says which is its own. */
  document.querySelectorAll('[data-chart]').forEach((host) => {
    const found = data[host.dataset.chart], of = host.dataset.of;
    modal.charts[host.dataset.chart](host, of === undefined ? found : found[Number(of)]);
  });
})(window.modal);
