"""Verdicts of many records of a family, as rates with standard errors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math

import numpy as np

from benchmarks.families.judge import PRODUCT_EDGES, Verdict


@dataclass(frozen=True)
class Rate:
    """A share or a number a run, its standard error and out of how many; NaN: out of none."""

    value: float
    error: float
    n: float

    def __str__(self) -> str:
        """Return value and standard error."""
        return '-' if math.isnan(self.value) else f'{self.value:.3f} ± {self.error:.3f}'


def rate(counts: Sequence[float], out_of: Sequence[float]) -> Rate:
    """Return the ratio of sums and its standard error over records, which are independent.

    References
    ----------
    Cochran (1977), Sampling Techniques, Eq. (6.13).
    """
    x, n = np.array(counts, dtype=float), np.array(out_of, dtype=float)
    used = n > 0
    x, n = x[used], n[used]
    if not len(n):
        return Rate(math.nan, math.nan, 0.0)
    value = x.sum() / n.sum()
    spread = math.sqrt(float(np.sum((x - value * n) ** 2)) * len(n) / max(1, len(n) - 1))
    return Rate(float(value), spread / float(n.sum()), float(n.sum()))


@dataclass(frozen=True)
class Tally:
    """All records of one family that one identifier has seen."""

    verdicts: Sequence[Verdict]

    def recall(self, place: int) -> Rate:
        """Return the recall in one bin of ζ f T."""
        return rate(
            [v.found[place] for v in self.verdicts], [v.asked[place] for v in self.verdicts]
        )

    def each_run(self, name: str) -> Rate:
        """Return a count per run."""
        return rate([getattr(v, name) for v in self.verdicts], [1] * len(self.verdicts))

    def inside(self, part: int) -> Rate:
        """Return the share of frequencies (0) or damping ratios (1) with the truth within 2σ."""
        known = [
            [each[part] for each in v.inside if each[part] is not None] for v in self.verdicts
        ]
        return rate([sum(map(bool, each)) for each in known], [len(each) for each in known])

    @property
    def shapes(self) -> Rate:
        """Return the share of the components of shapes with the truth within 2σ."""
        return rate(
            [sum(each[0] for each in v.shapes) for v in self.verdicts],
            [sum(each[1] for each in v.shapes) for v in self.verdicts],
        )

    @property
    def losses(self) -> Rate:
        """Return the share of shapes whose loss of MAC is within two deviations of its mean."""
        return rate(
            [sum(each[2] for each in v.losses) for v in self.verdicts],
            [len(v.losses) for v in self.verdicts],
        )

    def scatter(self, part: int) -> tuple[float, float]:
        """Return the scatter where ζ f T > 2, by the median and as rms.

        Parameters
        ----------
        part : int
            1, 2: f and ζ over the law; 3, 4: over the bound.
        """
        errors = np.array(
            [
                each[part]
                for v in self.verdicts
                for each in v.errors
                if each[0] > PRODUCT_EDGES[-1] and math.isfinite(each[part])
            ]
        )
        if not len(errors):
            return math.nan, math.nan
        return float(np.median(np.abs(errors)) / 0.6745), float(np.sqrt(np.mean(errors**2)))

    @property
    def modes_as_lines(self) -> list[int]:
        """Return the modes called lines by bin of ζ f T."""
        return [sum(v.modes_as_lines[place] for v in self.verdicts) for place in range(3)]

    def found_more(self, other: 'Tally') -> Rate:
        """Return by how much the recall is above another's on the same records."""
        pairs = self._paired(other)
        return rate(
            [sum(own.found) - sum(its.found) for own, its in pairs],
            [sum(own.asked) for own, _ in pairs],
        )

    def false_more(self, other: 'Tally') -> Rate:
        """Return how many more modes a run are made up than another makes up."""
        pairs = self._paired(other)
        return rate([own.n_made_up - its.n_made_up for own, its in pairs], [1] * len(pairs))

    def _paired(self, other: 'Tally') -> list[tuple[Verdict, Verdict]]:
        by_seed = {v.seed: v for v in other.verdicts}
        return [(v, by_seed[v.seed]) for v in self.verdicts if v.seed in by_seed]

    def total(self, name: str) -> int:
        """Return the sum of a count."""
        return sum(getattr(v, name) for v in self.verdicts)

    @property
    def score(self) -> int:
        """Modes found less modes made up."""
        return sum(sum(v.found) - v.n_made_up for v in self.verdicts)


def best(tallies: Mapping[str, Tally]) -> str:
    """Return who found the most, less what was made up."""
    return max(tallies, key=lambda who: tallies[who].score)
