"""A program that writes windows until it is killed, and says which are on the disk."""

from pathlib import Path
import sys

import numpy as np

from modal_history.store import HistoryWriter
from test.support.kept_results import ROBOT, window

path, first, count = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
rng = np.random.default_rng(first)
with HistoryWriter(path) as writer:
    for number in range(first, first + count):
        writer.add(ROBOT, [window(number, rng)])
        sys.stdout.write(f'{number}\n')
        sys.stdout.flush()
