/* Tables, lists and sentences out of plain values. What a message says is only ever shown as text. */
(function (modal) {
  'use strict';

  /* A longer text gets a box of its own, so that no name from elsewhere makes a row taller than the screen. */
  const LONG = 80;

  function cells(row, tag, list) {
    list.forEach(([text, kind, span]) => {
      const long = String(text).length > LONG, made = modal.element(tag, kind, long ? undefined : text);
      if (long) made.append(modal.element('div', 'long', text));
      if (span > 1) made.colSpan = span;
      if (tag === 'th') made.scope = 'col';
      row.append(made);
    });
    return row;
  }

  modal.table = (data) => {
    const box = modal.element('div', 'scroll'), table = modal.element('table');
    box.tabIndex = 0;
    box.setAttribute('role', 'region');
    box.setAttribute('aria-label', data.label);
    if (data.caption) {
      const caption = modal.element('caption');
      caption.append(modal.element('span', '', data.caption));
      table.append(caption);
    }
    const head = modal.element('thead'), body = modal.element('tbody');
    head.append(cells(modal.element('tr'), 'th', data.headings));
    data.rows.forEach((row) => body.append(cells(modal.element('tr', row.kind), 'td', row.cells)));
    if (!data.rows.length) {
      const columns = data.headings.reduce((sum, [, , span]) => sum + span, 0);
      body.append(cells(modal.element('tr'), 'td', [[data.empty, '', columns]]));
    }
    table.append(head, body);
    box.append(table);
    return box;
  };

  modal.entries = (pairs) => {
    const list = modal.element('dl');
    pairs.forEach(([name, value]) => {
      const pair = modal.element('div');
      pair.append(modal.element('dt', '', name), modal.element('dd', '', value));
      list.append(pair);
    });
    return list;
  };

  modal.sentences = (texts, kind) => texts.map((text) => modal.element('p', 'sentence ' + (kind || ''), text));

  modal.section = (title, ...parts) => {
    const made = modal.element('section');
    made.append(modal.element('h2', '', title), ...parts);
    return made;
  };
})(window.modal);
