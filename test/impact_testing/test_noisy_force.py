"""A force sensor with noise: masses are no surer than it, and no mode explains it."""

import numpy as np
import pytest

from impact_testing import Fault, find_taps, impact_modes, ImpactRecord, judge_taps
from modal_core.channel import Channel
from modal_core.errors import IdentificationError
from modal_core.samples import Samples
from test.support.hammer_bench import even_chain, taps

SEED = 982_400


def test_masses_are_no_surer_than_the_force():
    rng = np.random.default_rng(SEED)
    structure = even_chain()
    record = taps(structure, 4, 1.0 + 3.0 * np.arange(4), rng, last_s=3.0, noise=1e-3)
    force_n = record.force_n + 0.01 * record.force_n.max() * rng.normal(size=len(record.force_n))
    found = impact_modes([ImpactRecord(force_n, record.responses, record.hit)])
    poles, _ = structure.modes()
    assert found.modes.frequency_hz == pytest.approx(np.abs(poles) / 2 / np.pi, rel=2e-3)
    std = [each.modal_mass_std_kg / each.modal_mass_kg for each in found.scaled_modes]
    assert min(std) > 1e-3, f'seed {SEED}'


def test_taps_within_a_rebound_of_each_other_are_told_as_too_close():
    rate_hz = 1024.0
    force_n = np.zeros(4096)
    for row in range(1024, 3072, 184):
        force_n[row : row + 3] = 60.0, 100.0, 55.0
    still = Samples(np.zeros((4096, 1)), rate_hz, (Channel('m.x'),))
    record = ImpactRecord(force_n, still, 'm.x')
    (judged,) = judge_taps(record)
    assert find_taps(force_n, rate_hz)[0].goes_on_s == pytest.approx(11 * 184 / rate_hz, rel=0.01)
    assert judged.has(Fault.TOO_CLOSE)
    with pytest.raises(IdentificationError, match=r'too close.*wait until the structure rests'):
        impact_modes([record])
