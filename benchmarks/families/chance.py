"""Numbers drawn at random."""

import numpy as np

from benchmarks.families.family import Range


def log_uniform(rng: np.random.Generator, limits: Range) -> float:
    """Draw a number, every ratio as likely."""
    return float(np.exp(rng.uniform(*np.log(limits))))


def whole(rng: np.random.Generator, limits: tuple[int, int]) -> int:
    """Draw a whole number, every ratio about as likely."""
    return int(np.exp(rng.uniform(np.log(limits[0]), np.log(limits[1] + 1))))
