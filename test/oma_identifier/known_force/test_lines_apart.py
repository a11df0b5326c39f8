"""Teeth stand far above the noise of a force's sensor, what is between their lines does not."""

import math

import numpy as np
from scipy.signal import decimate, firwin, lfilter

from modal_core.channel import Channel
from modal_core.mode import Mode, ModeSet
from modal_core.samples import Samples
from oma_identifier.known_force import lines_apart, modal_scaling
from oma_identifier.methods import identify_by

HZ, ZETA = np.array([9.0, 17.3, 24.0]), np.array([0.02, 0.012, 0.025])
RATE_HZ, FINER, DURATION_S, SEED = 64.0, 8, 60.0, 702_100
BAND = firwin(101, (5.0, 25.0), fs=RATE_HZ, pass_zero=False)
CHANNELS = tuple(Channel(f'at {number}') for number in range(5))


def structure_under_cut(seed):
    """Samples, and modes that are known: shapes, and the motion at the largest entry per force.

    Chips of unequal teeth at a steady speed, and chips that break; the sensor adds noise.

    Each mode is the exact recursion of one complex pole, forces held at eight times the rate.
    """
    rng = np.random.default_rng(seed)
    fine_hz = FINER * RATE_HZ
    n = round((DURATION_S + 10.0) * fine_hz)
    angle = 2.0 * math.pi * rng.uniform(2.5, 6.0) * np.arange(n) / fine_hz
    cut = np.zeros(n)
    for tooth in range(3):
        at = np.mod(angle + 2.0 * math.pi * tooth / 3.0, 2.0 * math.pi)
        cut += np.where(at < 1.8, (0.1 + rng.uniform(0.0, 0.05)) * np.sin(at) + 0.02, 0.0)
    cut /= cut.std()
    white = math.sqrt(FINER) * rng.standard_normal((n, 4))
    force = cut + 0.03 * white[:, 0]
    rows = np.zeros((n, len(CHANNELS)))
    shapes = rng.standard_normal((len(CHANNELS), len(HZ)))
    into = rng.uniform(0.5, 1.5, len(HZ))
    for mode, (omega, zeta) in enumerate(zip(2.0 * math.pi * HZ, ZETA, strict=True)):
        pole = complex(-zeta * omega, omega * math.sqrt(1.0 - zeta**2))
        step = np.exp(pole / fine_hz)
        load = into[mode] * force + 0.01 * white[:, 1 + mode]
        state = lfilter([0.0, (step - 1.0) / pole], [1.0, -step], load.astype(complex))
        rows += np.outer(load + np.imag(pole**2 * state) / pole.imag, shapes[:, mode])
    late = slice(round(10.0 * RATE_HZ), None)
    responses = decimate(rows, FINER, ftype='fir', axis=0)[late]
    responses += 0.01 * responses.std(axis=0) * rng.standard_normal(responses.shape)
    measured = decimate(force, FINER, ftype='fir')[late]
    measured += 0.02 * measured.std() * rng.standard_normal(len(measured))
    largest = np.abs(shapes).max(axis=0)
    samples = Samples(responses, RATE_HZ, CHANNELS, known=measured[:, None])
    return samples, shapes / largest, into * largest


def test_modes_under_a_milling_force_are_within_their_deviations():
    seeds = range(SEED, SEED + 6)
    print('seeds', seeds)
    away = []
    for seed in seeds:
        samples = structure_under_cut(seed)[0]
        modes = identify_by('force', samples, inputs=samples.known).modes
        for hz, zeta in zip(HZ, ZETA, strict=True):
            mode = min(modes, key=lambda each: abs(each.frequency_hz - hz))
            if abs(mode.frequency_hz - hz) < 2.0 * zeta * hz:
                away.append([
                    (mode.frequency_hz - hz) / mode.frequency_std_hz,
                    (mode.damping_ratio - zeta) / mode.damping_ratio_std,
                ])  # fmt: skip
    size = np.abs(away)
    print(len(size), np.sort(size, axis=0)[-6:], np.sqrt(np.mean(size**2, axis=0)))
    assert len(size) >= 16
    assert (np.mean(size < 2.0, axis=0) > 0.9).all()
    assert size.max() < 3.0


def test_scales_under_a_milling_force_do_not_shrink_by_the_noise_of_its_sensor():
    seeds = range(SEED + 50, SEED + 58)
    print('seeds', seeds)
    off = []
    for seed in seeds:
        samples, shapes, per_force = structure_under_cut(seed)
        modes = tuple(
            Mode(float(hz), float(zeta), shape.astype(complex))
            for hz, zeta, shape in zip(HZ, ZETA, shapes.T, strict=True)
        )
        found = modal_scaling(samples, ModeSet(modes, samples.channel_names, 'force'))
        off += [
            abs(one.per_force) / true - 1.0 for one, true in zip(found, per_force, strict=True)
        ]
    print(np.round(off, 3))
    assert abs(np.median(off)) < 0.006
    assert np.median(np.abs(off)) < 0.02


def test_lines_and_rest_are_the_force_again_and_random_forces_stay_whole():
    rng = np.random.default_rng(SEED)
    print('seed', SEED)
    time = np.arange(round(40.0 * RATE_HZ)) / RATE_HZ
    tone, random = 5.0 * np.sin(2.0 * math.pi * 7.3 * time), rng.standard_normal(len(time))
    parts, rows = lines_apart((tone + random)[:, None], RATE_HZ)
    whole = tone + random
    assert np.allclose(parts.sum(axis=1), whole - whole.mean())
    assert len(parts[rows]) >= 0.85 * len(time) - 1
    off = parts[rows][:, 0] - tone[rows]
    assert off.std() < 0.25, 'the random force within half a hertz of 32 is an eighth'
    for forced in (random, decimate(random, 2, ftype='fir').repeat(2), lfilter(BAND, 1.0, random)):
        alone, rows = lines_apart(forced[:, None], RATE_HZ)
        assert alone.shape == (len(time), 1)
        assert len(alone[rows]) == len(time)


def test_a_record_of_some_samples_stays_whole():
    force = np.sin(np.arange(12.0))[:, None]
    parts, rows = lines_apart(force, RATE_HZ)
    assert parts.shape == force.shape
    assert len(parts[rows]) == 12
