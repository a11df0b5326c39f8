"""The control law against its own transfer function."""

import cmath
import math

import numpy as np
import pytest

from abb_emulator.controller_settings import CYCLE_S
from abb_emulator.egm.guidance_law import GuidanceLaw, GuidanceSettings

WIDE = {'max_speed_deviation_deg_s': 1e3, 'condition_time_s': 1e9, 'ramp_in_s': CYCLE_S}


def theory(hz, gain, cutoff, speed_reference):
    """H(z) from position reference to position, with or without the speed reference."""
    z = cmath.exp(2j * math.pi * hz * CYCLE_S)
    keep = math.exp(-2 * math.pi * cutoff * CYCLE_S) if cutoff else 0.0
    low_pass = (1 - keep) / (1 - keep / z)
    integral = CYCLE_S * z / (z - 1)  # position after the cycle, per speed in it
    # The error uses the position before the cycle, one step old.
    loop = gain * low_pass * integral
    forward = (gain + ((z - 1) / CYCLE_S if speed_reference else 0.0)) * low_pass * integral
    return forward / (1 + loop / z)


def measured(hz, settings, speed_reference, seconds=12.0):
    law = GuidanceLaw(settings, np.zeros(6), CYCLE_S)
    n = int(seconds / CYCLE_S)
    phase = 2 * math.pi * hz * CYCLE_S * np.arange(n + 1)
    reference = 0.05 * np.sin(phase)
    out = np.empty(n)
    for k in range(n):
        speed = np.full(6, (reference[k + 1] - reference[k]) / CYCLE_S)
        law.refer(np.full(6, reference[k]), speed if speed_reference else None)
        out[k] = law.step()[0]
    tail = slice(n // 2, n)
    basis = np.exp(-1j * phase[:n][tail])
    window = np.hanning(len(basis))
    return np.sum(out[tail] * basis * window) / np.sum(reference[:n][tail] * basis * window)


@pytest.mark.parametrize('hz', [1.0, 10.0, 20.0, 50.0])
@pytest.mark.parametrize(
    ('gain', 'cutoff', 'speed_reference'), [(5.0, 20.0, False), (20.0, 100.0, False),
                                            (5.0, 100.0, True), (5.0, 20.0, True)],
)  # fmt: skip
def test_gain_and_phase_are_those_of_the_law(hz, gain, cutoff, speed_reference):
    settings = GuidanceSettings(gain_1_s=gain, low_pass_hz=cutoff, **WIDE)
    np.testing.assert_allclose(
        measured(hz, settings, speed_reference),
        theory(hz, gain, cutoff, speed_reference),
        rtol=2e-3,
    )


def test_position_only_has_the_slow_pole_the_manual_warns_of():
    law = GuidanceLaw(GuidanceSettings(low_pass_hz=0.0, **WIDE), np.zeros(6), CYCLE_S)
    law.refer(np.ones(6), None)
    n_cycles = 1
    while law.step()[0] < 1.0 - math.exp(-1.0):
        n_cycles += 1
    time_s = n_cycles * CYCLE_S
    assert time_s == pytest.approx(0.2, abs=0.01)  # 1 / k, a pole at 0.8 Hz


def test_the_last_speed_keeps_acting():
    law = GuidanceLaw(GuidanceSettings(**WIDE), np.zeros(6), CYCLE_S)
    law.refer(np.zeros(6), np.full(6, 0.5))
    for _ in range(2500):
        law.step()
    assert law.position_deg[0] == pytest.approx(0.5 / 5.0, rel=1e-3)  # speed_ref / k


def test_default_speed_deviation_is_the_trap_it_is():
    law = GuidanceLaw(GuidanceSettings(condition_time_s=1e9), np.zeros(6), CYCLE_S)
    law.refer(np.full(6, 10.0), np.full(6, 100.0))
    for _ in range(300):
        law.step()
        assert np.abs(law.speed_deg_s).max() <= 1.0 + 1e-12


def test_position_deviation_is_an_envelope():
    settings = GuidanceSettings(max_position_deviation_deg=0.2, **WIDE)
    law = GuidanceLaw(settings, np.full(6, 30.0), CYCLE_S)
    law.refer(np.full(6, 40.0), None)
    for _ in range(1000):
        law.step()
    np.testing.assert_allclose(law.position_deg, 30.2)


def test_a_session_inside_its_window_ends_by_itself_after_cond_time():
    law = GuidanceLaw(GuidanceSettings(), np.zeros(6), CYCLE_S)
    law.refer(np.full(6, 0.3), None)
    n = 0
    while not law.finished:
        law.step()
        n += 1
        assert n < 1000
    assert n * CYCLE_S == pytest.approx(1.0 + 0.5, abs=0.02)


def test_only_selected_axes_count_for_convergence():
    selected = (True, False, True, True, True, True)
    law = GuidanceLaw(GuidanceSettings(selected=selected), np.zeros(6), CYCLE_S)
    target = np.zeros(6)
    target[1] = 400.0
    law.refer(target, None)
    law.step()
    assert law.converged


@pytest.mark.parametrize('back', [False, True])
def test_a_session_ends_where_it_is_or_where_it_began(back):
    settings = GuidanceSettings(stop_ramp_down=back, ramp_out_s=0.4, **WIDE)
    law = GuidanceLaw(settings, np.full(6, 10.0), CYCLE_S)
    law.refer(np.full(6, 12.0), None)
    for _ in range(1000):
        law.step()
    law.end()
    path = [law.position_deg]
    while not law.finished:
        path.append(law.step())
    assert len(path) * CYCLE_S == pytest.approx(0.4, abs=3 * CYCLE_S)
    np.testing.assert_allclose(path[-1], 10.0 if back else 12.0, atol=1e-6 if back else 0.03)
    # At rest at the end, and nowhere faster than 1.5 times the mean.
    steps = np.abs(np.diff(np.array(path), axis=0))
    assert steps[-1].max() < 0.02
    assert steps.max() <= 1.6 * 2.0 * CYCLE_S / 0.4
