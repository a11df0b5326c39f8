"""A clock that runs away is told from a late command, and the other way round."""

import numpy as np
import pytest

from model_gap.effects.clock_drift import ClockDrift
from model_gap.effects.command_delay import CommandDelay
from model_gap.fit.fit import fit
from model_gap.search import EVIDENCE_BETWEEN, Search

SEED = 27


@pytest.mark.parametrize(
    ('hidden', 'right', 'wrong', 'truth'),
    [
        ({'type': 'clock_drift', 'rate': 3.3e-5}, ClockDrift(), CommandDelay(), 3.3e-5),
        ({'type': 'command_delay', 'delay': 3e-4}, CommandDelay(), ClockDrift(), 3e-4),
    ],
)
def test_a_drift_is_no_delay(hidden, right, wrong, truth, campaign_of, robot):
    campaign = campaign_of([hidden], SEED, n_held=0, duration=16.0)
    search = Search.begin(robot, campaign)
    fits = {}
    for effect in (right, wrong):
        start = min(effect.starts(search.scene), key=lambda values: abs(values[0]))
        fits[effect] = fit(search.nominal.with_effect(effect, start), search.data.fitting)
    lead = fits[right].log_evidence - fits[wrong].log_evidence
    (found,) = fits[right].hypothesis.inner
    sigma = float(np.sqrt(fits[right].covariance[0, 0]))
    assert lead > EVIDENCE_BETWEEN, f'seed {SEED}'
    assert abs(found - truth) < 3.0 * sigma < 0.3 * truth, f'seed {SEED}'
