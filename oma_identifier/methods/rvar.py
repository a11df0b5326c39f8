"""Recursive vector autoregressive model with forgetting, for modes that move.

A sample of age a has the weight exp(-a / τ) in the sums of the model (:mod:`.var`), with the
memory τ.  Sums that are multiplied by the forgetting factor β = exp(-1 / (τ fs)) with every new
sample, and to which its products are added, are the same (recursive least squares).  Here they
are those of faded samples exp(-a / 2τ) z: the model of these has the coefficients
A_i exp(i / (2τ fs)) and its poles are λ + 1 / (2τ), which is taken off again.  So nothing is
approximated but what is older than some memories and left out.

The modes are those of the time τ before the end, the mean of the weights: where a mode moves
steadily the estimate is not late against that time.  A memory of half a window, the default, puts
it in the middle of the window; the memory reaches back into earlier ones.  By
(Σ w)² / Σ w² = 2τ the samples tell as much as 2τ seconds of equal weight would: bands, orders and
the limit of scatter are those of so short a record.

Standard deviations are by the jackknife of blocks, each with its weight.  What a mode moves within
the memory is part of its scatter.

References
----------
Ljung and Söderström (1983), Theory and Practice of Recursive Identification (forgetting factor);
Vu, Thomas, Lakis and Marcouiller (2011), doi:10.1016/j.ymssp.2010.08.006 (vector AR of operational
modal analysis).
"""

from collections.abc import Sequence
from dataclasses import replace
import math

import numpy as np

from modal_core.samples import Samples
from oma_identifier.methods.banded import Problem
from oma_identifier.methods.solver import SolvedAnew
from oma_identifier.methods.var import Var
from oma_identifier.motion import never, PeakTest
from oma_identifier.selection import Identified
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace import RawPoles


class RecursiveVar(Var):
    """Vector AR that forgets; deviations by the jackknife of blocks by their weights."""

    name = 'rvar'

    def identify(
        self,
        samples: Samples,
        settings: IdentificationSettings,
        inputs: np.ndarray | None = None,
        explains: PeakTest = never,
    ) -> Identified:
        """Identify the modes as they are a memory before the end of the stretch."""
        n_rows = math.ceil(settings.reach_s * samples.sample_rate_hz)
        if n_rows < len(samples.acceleration):
            samples = samples.part(slice(len(samples.acceleration) - n_rows, None))
        return super().identify(samples, settings, inputs, explains)

    def counted_s(self, samples: Samples, settings: IdentificationSettings) -> float:
        """Return (Σ w)² / Σ w² of the weights [s]."""
        twice_s = 2.0 * settings.memory
        return twice_s * math.tanh(samples.duration_s / twice_s)

    def weighted(self, problem: Problem, settings: IdentificationSettings) -> Problem:
        """Return the band with its samples faded by their age."""
        steps = 2.0 * settings.memory * problem.band.sample_rate_hz
        age = np.arange(len(problem.rows))[::-1, None]
        return replace(problem, rows=problem.rows * np.exp(-age / steps))

    def prepare(self, problem: Problem, settings: IdentificationSettings) -> SolvedAnew:
        """Sum the products of faded samples; the poles are freed of the fading."""
        faded = super().prepare(problem, settings)
        fading = math.exp(-0.5 / (settings.memory * problem.band.sample_rate_hz))

        def solve(orders: Sequence[int], left_out: tuple[int, int] | None) -> RawPoles:
            found = faded.anew(orders, left_out)
            return RawPoles(found.model_order, fading * found.eigenvalue, found.shape)

        return SolvedAnew(solve)
