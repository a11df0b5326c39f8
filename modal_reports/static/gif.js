/* Pictures as an animated GIF that every program shows: few colours, LZW (Welch, 1984; GIF89a). */
(function (modal) {
  'use strict';

  const BITS = 8, MOST_COLOURS = 256;
  const coarse = (value) => Math.min(255, 17 * Math.round(value / 17));   /* sixteen steps a channel */

  /* Frames as indices into their common palette, the rarest colours as the nearest of the others. */
  function indexed(frames) {
    const counts = new Map();
    const keys = frames.map((pixels) => {
      const found = new Uint32Array(pixels.length / 4);
      for (let i = 0; i < found.length; i++) {
        found[i] = (coarse(pixels[4 * i]) << 16) | (coarse(pixels[4 * i + 1]) << 8) | coarse(pixels[4 * i + 2]);
        counts.set(found[i], (counts.get(found[i]) || 0) + 1);
      }
      return found;
    });
    const palette = [...counts.keys()].sort((a, b) => counts.get(b) - counts.get(a)).slice(0, MOST_COLOURS);
    const place = new Map(palette.map((colour, index) => [colour, index]));
    const far = (a, b) => [16, 8, 0].reduce((sum, shift) => sum + Math.pow(((a >> shift) & 255) - ((b >> shift) & 255), 2), 0);
    counts.forEach((_, colour) => {
      if (!place.has(colour)) place.set(colour, palette.reduce((best, other, index) => (far(colour, other) < far(colour, palette[best]) ? index : best), 0));
    });
    return { palette, frames: keys.map((found) => Uint8Array.from(found, (colour) => place.get(colour))) };
  }

  function packed(indices) {
    const bytes = [], clear = 1 << BITS, end = clear + 1;
    let table = new Map(), size = BITS + 1, next = end + 1, held = 0, n_held = 0;
    const put = (code) => {
      held |= code << n_held; n_held += size;
      while (n_held >= 8) { bytes.push(held & 255); held >>>= 8; n_held -= 8; }
    };
    put(clear);
    let code = indices[0];
    for (let i = 1; i < indices.length; i++) {
      const key = (code << 8) | indices[i], known = table.get(key);
      if (known !== undefined) { code = known; continue; }
      put(code);
      table.set(key, next);
      if (next === 1 << size && size < 12) size++;
      if (++next > 4095) { put(clear); table = new Map(); size = BITS + 1; next = end + 1; }
      code = indices[i];
    }
    put(code); put(end);
    if (n_held) bytes.push(held & 255);
    return bytes;
  }

  const word = (value) => [value & 255, value >> 8];
  const letters = (text) => [...text].map((letter) => letter.charCodeAt(0));

  /* Frames: RGBA of opaque pictures of one size; a delay in hundredths of a second. */
  modal.gif = (frames, width, height, delay) => {
    const found = indexed(frames), colours = new Uint8Array(3 * MOST_COLOURS);
    found.palette.forEach((colour, i) => { colours[3 * i] = colour >> 16; colours[3 * i + 1] = (colour >> 8) & 255; colours[3 * i + 2] = colour & 255; });
    const parts = [Uint8Array.from([...letters('GIF89a'), ...word(width), ...word(height), 0xF7, 0, 0]), colours,
      Uint8Array.from([0x21, 0xFF, 11, ...letters('NETSCAPE2.0'), 3, 1, 0, 0, 0])];
    found.frames.forEach((indices) => {
      parts.push(Uint8Array.from([0x21, 0xF9, 4, 4, ...word(delay), 0, 0, 0x2C, 0, 0, 0, 0, ...word(width), ...word(height), 0, BITS]));
      const bytes = packed(indices);
      for (let i = 0; i < bytes.length; i += 255) { const block = bytes.slice(i, i + 255); parts.push(Uint8Array.from([block.length, ...block])); }
      parts.push(Uint8Array.of(0));
    });
    parts.push(Uint8Array.of(0x3B));
    return new Blob(parts, { type: 'image/gif' });
  };

  modal.save = (blob, name) => {
    const link = modal.element('a');
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    URL.revokeObjectURL(link.href);
  };
})(window.modal);
