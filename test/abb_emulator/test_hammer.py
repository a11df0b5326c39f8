"""Taps on the emulated arm: its own FRFs, and what a person does wrong."""

from dataclasses import replace

import numpy as np
import pytest

from abb_emulator.hammer import HammerTaps, tap
from impact_testing import Fault, frac, ImpactRecord, judge_taps, PointFrf, PointSpectra
from structural_model import load_layout, load_robot

ROBOT, SEED = 'irb6660_205_190', 44


@pytest.fixture(scope='module')
def arm():
    model = load_robot(ROBOT)
    return model, model.pose('P1'), load_layout(ROBOT).channels[-6:]


def taps(arm, how):
    model, pose, channels = arm
    found = tap(model, pose, channels, channels[-1], how, np.random.default_rng(SEED))
    return ImpactRecord(found.force_n, found.responses, found.hit)


def test_frfs_of_taps_are_those_of_the_model(arm):
    model, pose, channels = arm
    record = taps(arm, HammerTaps(n_taps=3, pause_s=12.0, noise_m_s2=1e-6, force_noise_n=1e-6))
    frf = PointFrf(PointSpectra.of(record, judge_taps(record), 10.0))
    band = slice(40, 1500)
    true = model.frf(pose, channels[-1:], channels, frf.spectra.frequency_hz[band])[:, :, 0]
    assert frac(frf.h1[band], true) == pytest.approx(1.0, abs=1e-4)


def test_a_bounce_and_a_clipped_converter_are_there_and_named(arm):
    how = HammerTaps(double=(2,))
    said = [{fault for fault, _ in each.faults} for each in judge_taps(taps(arm, how))]
    assert said == [set(), set(), {Fault.DOUBLE_HIT}, set(), set()]
    # Three samples at the limit tell: a pulse has twelve at this rate.
    clipped = taps(arm, replace(how, double=(), range_n=120.0, sample_rate_hz=2048.0))
    said = set().union(*({f for f, _ in each.faults} for each in judge_taps(clipped)))
    assert said == {Fault.FORCE_CLIPPED}
