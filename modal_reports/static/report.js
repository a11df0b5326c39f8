/* Put the charts into a page that holds their data. */
(function (modal) {
  'use strict';
  const data = JSON.parse(document.getElementById('report-data').textContent);
  document.querySelectorAll('[data-chart]').forEach((host) => modal.charts[host.dataset.chart](host, data[host.dataset.chart]));
})(window.modal);
