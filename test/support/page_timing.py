"""How often the page draws the arm, and how soon it shows a result, as the browser tells."""

from dataclasses import dataclass
import time

import numpy as np

PAUSE_S = 0.3
SPECTRUM, SHAPES = 'Singular values of the responses, window', 'Modes of window'
FRAMES = """new Promise((done) => {
  const canvas = document.querySelector('main .card:not(.flat) canvas');
  const context = canvas.getContext('2d'), stroke = CanvasRenderingContext2D.prototype.stroke;
  const stamps = [];
  let drawn = 0, touched = false;
  context.stroke = function (...path) { touched = true; return stroke.apply(this, path); };
  const step = (now) => {
    stamps.push(now);
    drawn += touched;
    touched = false;
    if (stamps.length < COUNT) requestAnimationFrame(step);
    else { delete context.stroke; done({ stamps, drawn }); }
  };
  requestAnimationFrame(step);
})"""
# A message is handled after the frame in which it was sent has been painted.
SEEN = """(() => {
  window.seen = {};
  if (window.watching) window.watching.disconnect();
  const main = document.querySelector('main'), after = new MessageChannel(), waiting = [];
  after.port1.onmessage = () => {
    const now = performance.timeOrigin + performance.now();
    while (waiting.length) window.seen[waiting.pop()] = now;
  };
  window.watching = new MutationObserver(() => {
    const found = /SAID (\\d+)/.exec(main.textContent);
    if (!found || found[1] in window.seen) return;
    window.seen[found[1]] = 0;
    waiting.push(found[1]);
    after.port2.postMessage(0);
  });
  window.watching.observe(main, { childList: true, subtree: true });
})()"""


@dataclass(frozen=True)
class Frames:
    """Frames of a page that moves.

    Parameters
    ----------
    intervals_ms : (n,) array [ms]
        Between the frames that the browser gave.
    drawn : float
        Share of them in which the arm was drawn anew.
    """

    intervals_ms: np.ndarray
    drawn: float

    @property
    def rate_hz(self) -> float:
        """Frames a second [Hz]."""
        return 1000.0 / float(np.mean(self.intervals_ms))


def measure_frames(page, count=240):
    """Return so many frames of the screen with mode shapes, which must be open and moving."""
    found = page.evaluate(FRAMES.replace('COUNT', str(count + 1)))
    # What was drawn before the first stamp is of no interval.
    return Frames(np.diff(found['stamps']), min(1.0, (found['drawn']) / count))


def measure_delays(page, cell, results, said, count=20):
    """Return the time from publishing a result to its paint, (count,) [ms].

    Both clocks are this machine's.

    Parameters
    ----------
    page, cell, results
        A browser's page, who publishes to it, and what.
    said : str
        What stands before the number of the window on the screen that is open.
    """
    page.evaluate(SEEN.replace('SAID', said))
    delays = []
    for _ in range(count):
        given = results.next()
        begin_ms = 1000.0 * time.time()
        cell.publish(given)
        delays.append(page.until(f'window.seen[{given.index}]') - begin_ms)
        # A picture that is still being made would be waited for by the next.
        time.sleep(PAUSE_S)
    return np.array(delays)
