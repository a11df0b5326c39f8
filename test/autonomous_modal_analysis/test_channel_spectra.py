"""Spectra of channels in a report: against theory, and against SciPy."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.signal

from autonomous_modal_analysis.report import channel_spectra
from modal_core.channel import Channel
from modal_core.mode import Mode
from modal_core.samples import Samples
from test.support.report_cases import Chain, RATE_HZ

BAND_HZ = (1.0, 57.0)


@pytest.fixture(scope='module')
def chain():
    """Six modes at six sensors, 300 s (seed 3), with the true modes."""
    made = Chain()
    data = made.acceleration(300.0, np.random.default_rng(3))
    samples = Samples(data, RATE_HZ, tuple(Channel(name=f's{n}.x') for n in range(6)))
    modes = [
        Mode(float(hz), float(zeta), made.shapes[:, n] + 0j)
        for n, (hz, zeta) in enumerate(zip(made.frequency_hz, made.damping_ratio, strict=True))
    ]
    return samples, modes


def test_they_are_those_of_scipy(chain):
    samples, modes = chain
    found = channel_spectra(samples, modes, BAND_HZ)
    length = round(RATE_HZ / (found.frequency_hz[1] - found.frequency_hz[0]))
    data = samples.acceleration
    at_hz, psd = scipy.signal.welch(data[:, 2], RATE_HZ, nperseg=length)
    shown = np.isin(np.round(at_hz, 9), np.round(found.frequency_hz, 9))
    np.testing.assert_allclose(found.psd[:, 2], psd[shown], rtol=0.02)
    place = found.names.index(found.reference)
    _, both = scipy.signal.coherence(data[:, 2], data[:, place], RATE_HZ, nperseg=length)
    np.testing.assert_allclose(found.coherence[:, 2], both[shown], atol=0.05)
    np.testing.assert_allclose(found.coherence[:, place], 1.0, rtol=1e-9)


def test_true_modes_explain_what_was_measured(chain):
    """Spectra of some 30 segments scatter by 18 %; so does what is left of them."""
    samples, modes = chain
    found = channel_spectra(samples, modes, BAND_HZ)
    ratio = found.psd / found.synthesised
    assert np.all(np.abs(np.mean(ratio, axis=0) - 1.0) < 0.05), 'seed 3'
    assert np.all(np.std(ratio, axis=0) < 0.35), 'seed 3'


def test_a_mode_that_is_not_listed_is_a_peak_without_a_bell(chain):
    samples, modes = chain
    found = channel_spectra(samples, [modes[0], *modes[2:]], BAND_HZ)
    near = np.argmin(np.abs(found.frequency_hz - modes[1].frequency_hz))
    assert np.max(found.psd[near] / np.abs(found.synthesised[near])) > 5.0


def test_odd_data_have_spectra_or_none(chain):
    """A dead channel, equal channels, a stretch of a second, no mode, a hundred channels."""
    samples, modes = chain
    data = np.array(samples.acceleration)
    data[:, 1], data[:, 2] = 0.0, data[:, 3]
    for listed in (modes, []):
        found = channel_spectra(replace(samples, acceleration=data), listed, BAND_HZ)
        for values in (found.psd, found.synthesised, found.coherence):
            assert np.isfinite(values).all()
        assert (found.coherence <= 1.0).all()
    assert channel_spectra(replace(samples, acceleration=data[:100]), modes, BAND_HZ) is None
    wide = np.tile(data[:20_000], (1, 20))
    names = tuple(Channel(name=f'w{n}.x') for n in range(120))
    found = channel_spectra(Samples(wide, RATE_HZ, names), modes, BAND_HZ)
    assert len(found.names) == 64 and len(found.frequency_hz) <= 501
