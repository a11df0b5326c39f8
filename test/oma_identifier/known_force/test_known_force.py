"""A measured force as known input: modes that do not depend on its lines, and modal masses."""

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.signal import decimate

from modal_core.channel import Channel
from modal_core.errors import IdentificationError, SettingsError
from modal_core.mode import Mode, ModeSet
from modal_core.numbers.indicators import mac
from modal_core.samples import Samples
from oma_identifier.known_force import KnownForce, modal_scaling
from oma_identifier.methods import identify_by
from oma_identifier.settings import IdentificationSettings

MASS = np.diag([10.0, 8.0, 6.0])
STIFFNESS = 1e3 * np.array([[60.0, -30.0, 0.0], [-30.0, 50.0, -20.0], [0.0, -20.0, 20.0]])
ZETA = np.array([0.02, 0.015, 0.03])
RATE_HZ, FINER, SEED = 64.0, 8, 700_301
CHANNELS = tuple(Channel(name) for name in ('one', 'two', 'three'))


def bench():
    """Frequencies [Hz], shapes of unit modal mass, and the damping matrix: by Cholesky."""
    root = np.diag(1.0 / np.sqrt(np.diag(MASS)))
    squares, vectors = np.linalg.eigh(root @ STIFFNESS @ root)
    shapes = root @ vectors
    omega = np.sqrt(squares)
    damping = MASS @ shapes @ np.diag(2.0 * ZETA * omega) @ shapes.T @ MASS
    return omega / (2.0 * math.pi), shapes, damping


def milled(seed, duration_s, unknown=0.0):
    """A cut at the third mass whose tooth passing sweeps, and forces that nobody measures.

    Integrated as one matrix exponential of the whole system, forces held at eight times the rate.
    """
    rng = np.random.default_rng(seed)
    fine_hz = FINER * RATE_HZ
    n = round(duration_s * fine_hz)
    time = np.arange(n) / fine_hz
    phase = 2.0 * np.pi * np.cumsum(3.0 + 17.0 * ((time / 30.0) % 1.0)) / fine_hz
    cut = 20.0 * np.sign(np.sin(phase)) + 5.0 * rng.standard_normal(n)
    force = unknown * 20.0 / math.sqrt(3.0) * rng.standard_normal((n, 3))
    force[:, 2] += cut
    damping = bench()[2]
    inverse = np.linalg.inv(MASS)
    zero, one = np.zeros((3, 3)), np.eye(3)
    system = np.block([[zero, one], [-inverse @ STIFFNESS, -inverse @ damping]])
    into = np.vstack([zero, inverse])
    both = expm(np.block([[system, into], [np.zeros((3, 9))]]) / fine_hz)
    state, rows = np.zeros(6), np.empty((n, 3))
    for index in range(n):
        rows[index] = system[3:] @ state + inverse @ force[index]
        state = both[:6, :6] @ state + both[:6, 6:] @ force[index]
    responses = decimate(rows, FINER, ftype='fir', axis=0)
    measured = decimate(cut, FINER, ftype='fir')
    responses += 0.02 * responses.std(axis=0) * rng.standard_normal(responses.shape)
    return Samples(responses, RATE_HZ, CHANNELS, known=measured[:, None])


def test_modes_and_masses_come_from_a_cut():
    """The bench of three masses; masses of 1/ψ² where the largest entry is one."""
    print('seed', SEED)
    hz, shapes, _ = bench()
    samples = milled(SEED, 120.0)
    modes = identify_by('force', samples, inputs=samples.known).modes
    for f, zeta, shape in zip(hz, ZETA, shapes.T, strict=True):
        mode = min(modes, key=lambda each: abs(each.frequency_hz - f))
        assert mode.frequency_hz == pytest.approx(f, rel=2e-3)
        assert mode.damping_ratio == pytest.approx(zeta, rel=0.1)
        assert mac(mode.shape, shape)[0, 0] > 0.999
    kept = ModeSet(
        tuple(min(modes, key=lambda each: abs(each.frequency_hz - f)) for f in hz),
        samples.channel_names,
        'force',
    )
    for scale, shape in zip(modal_scaling(samples, kept, 'three'), shapes.T, strict=True):
        assert scale.modal_mass_kg == pytest.approx(1.0 / np.max(np.abs(shape)) ** 2, rel=0.05)
        assert scale.explained > 0.9


def test_masses_are_exact_where_poles_and_shapes_are():
    hz, shapes, _ = bench()
    samples = milled(SEED + 1, 60.0)
    modes = ModeSet(
        tuple(
            Mode(float(f), float(z), (s / s[np.argmax(np.abs(s))]).astype(complex))
            for f, z, s in zip(hz, ZETA, shapes.T, strict=True)
        ),
        samples.channel_names,
        'force',
    )
    for scale, shape in zip(modal_scaling(samples, modes, 'three'), shapes.T, strict=True):
        assert scale.modal_mass_kg == pytest.approx(1.0 / np.max(np.abs(shape)) ** 2, rel=0.02)


def test_masses_under_forces_that_nobody_measured_are_within_their_deviations():
    """Unknown forces on all masses, as strong as the cut: eight records."""
    seeds = range(SEED + 10, SEED + 18)
    print('seeds', seeds)
    hz, shapes, _ = bench()
    modes = tuple(
        Mode(float(f), float(z), (s / s[np.argmax(np.abs(s))]).astype(complex))
        for f, z, s in zip(hz, ZETA, shapes.T, strict=True)
    )
    away = []
    for seed in seeds:
        samples = milled(seed, 60.0, unknown=1.0)
        for scale, shape in zip(
            modal_scaling(samples, ModeSet(modes, samples.channel_names, 'force'), 'three'),
            shapes.T,
            strict=True,
        ):
            true = 1.0 / np.max(np.abs(shape)) ** 2
            away.append((scale.modal_mass_kg - true) / scale.modal_mass_std_kg)
    print(np.round(away, 1))
    assert np.mean(np.abs(away) < 2.0) > 0.75
    assert 0.5 < np.sqrt(np.mean(np.square(away))) < 1.7


def test_a_shape_that_is_off_at_the_force_shows_in_the_deviation_of_its_mass():
    """Beside a node identified entries are off by more than what the regression tells."""
    hz, shapes, _ = bench()
    modes = []
    for f, z, shape in zip(hz, ZETA, shapes.T, strict=True):
        off = (shape / shape[np.argmax(np.abs(shape))]).astype(complex)
        off[2] *= 0.85
        modes.append(Mode(float(f), float(z), off / off[np.argmax(np.abs(off))]))
    samples = milled(SEED, 60.0, unknown=0.2)
    found = modal_scaling(samples, ModeSet(tuple(modes), samples.channel_names, 'force'), 'three')
    for scale, shape in zip(found, shapes.T, strict=True):
        true = 1.0 / np.max(np.abs(shape)) ** 2
        assert abs(scale.modal_mass_kg - true) < 3.0 * scale.modal_mass_std_kg, f'seed {SEED}'


def test_without_a_force_one_line_says_what_is_needed():
    samples = milled(SEED, 10.0)
    with pytest.raises(SettingsError, match='force needs the known inputs'):
        identify_by('force', samples)
    modes = ModeSet((Mode(4.5, 0.02, np.ones(3, complex)),), samples.channel_names, 'x')
    blind = Samples(samples.acceleration, RATE_HZ, CHANNELS)
    with pytest.raises(IdentificationError, match='measured force'):
        modal_scaling(blind, modes)
    with pytest.raises(IdentificationError, match='no such channel'):
        modal_scaling(samples, modes, 'four')


def test_a_force_of_another_rate_is_put_beside_the_responses():
    time = np.arange(4000) / 200.0
    force = KnownForce(np.sin(2.0 * np.pi * 5.0 * time)[:, None], 200.0, 1_000_000_000, 'cut')
    samples = Samples(np.zeros((640, 3)), 64.0, CHANNELS, start_ns=3_000_000_000)
    known = force.beside(samples).known
    expected = np.sin(2.0 * np.pi * 5.0 * (2.0 + np.arange(640) / 64.0))
    assert known[:, 0] == pytest.approx(expected, abs=2e-3)
    with pytest.raises(IdentificationError, match='does not cover'):
        force.beside(Samples(np.zeros((640, 3)), 64.0, CHANNELS))


def test_default_settings_name_the_method():
    assert IdentificationSettings(method='force').method == 'force'
