"""The live page in Chromium: frames a second of the moving arm, time from a result to pixels.

`python -m benchmarks.page`, with ROS and a browser as the tests of the page need them.
"""

from collections.abc import Iterator
import os
import subprocess

import numpy as np

from benchmarks.results import write_lines
from benchmarks.table import HEADER, Line

N_FRAMES, N_RESULTS = 600, 50
REACH_HZ, REACH_MS = 60.0, 50.0
ROUNDING = 0.99
"""A browser's frames are some hundredths of a hertz off."""


def rows() -> Iterator[Line]:
    """Yield the lines; of a browser without a graphics card, on a page of 1280 by 900 pixels."""
    # ROS and the browser are needed here alone.
    from test.support.browser import browser_page
    from test.support.live_cell import own_cell, Results, ROBOT
    from test.support.page_timing import measure_delays, measure_frames, SHAPES, SPECTRUM

    with own_cell(robot=ROBOT) as live, browser_page() as page:
        results = Results()
        live.publish(results.next())
        page.open(live.url, reduced=False, fragment='#modes')
        page.until('document.querySelectorAll("main .card:not(.flat)").length > 3')
        frames = measure_frames(page, N_FRAMES)
        delays = {'the shapes on the arm': measure_delays(page, live, results, SHAPES, N_RESULTS)}
        page.evaluate('window.location.hash = "spectrum"')
        page.until('document.body.innerText.includes("Singular values")')
        seen = measure_delays(page, live, results, SPECTRUM, N_RESULTS)
        delays = {'its spectrum and lines': seen, **delays}
    late_ms = float(np.quantile(frames.intervals_ms, 0.95))
    yield Line(
        f'{len(results.frequency_hz)} shapes on the arm, {N_FRAMES} frames: frames a second,'
        ' 95 % of the times between two',
        f'{frames.rate_hz:.1f}, ≤ {late_ms:.1f} ms',
        reach=f'≥ {REACH_HZ:.0f}',
        met=frames.rate_hz >= ROUNDING * REACH_HZ,
    )
    yield Line('frames in which the arm was drawn', f'{100.0 * frames.drawn:.0f} %')
    for what, delays_ms in delays.items():
        middle = float(np.median(delays_ms))
        yield Line(
            f'from the result on its topic to the pixels of {what}, {N_RESULTS} results:'
            ' quickest, median, largest',
            f'{delays_ms.min():.0f}, {middle:.0f}, {delays_ms.max():.0f} ms',
            reach=f'≤ {REACH_MS:.0f} ms',
            met=middle <= REACH_MS,
        )


def browser_version() -> str:
    """Return which browser it is."""
    from test.support.browser import find_browser

    command = [find_browser() or '', '--version']
    told = subprocess.run(command, capture_output=True, text=True, check=False)
    return ' '.join(told.stdout.split()[:2])


def main() -> None:
    """Measure, print and keep the table."""
    lines = list(rows())
    print(HEADER, *(line.markdown() for line in lines), sep='\n')
    n_busy = os.getloadavg()[0]
    where = f'{os.cpu_count()} processors, on the average {n_busy:.1f} busy programs'
    write_lines('page', lines, (browser_version(), where))


if __name__ == '__main__':
    main()
