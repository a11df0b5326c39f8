"""Tap tests of the arm against its true modes, beside sdypy-EMA with the same FRFs.

The peer is given the true frequencies to pick its poles at, since it asks a person for them; ours
is given nothing.
"""

from collections.abc import Iterator
from dataclasses import dataclass
import importlib.util

import numpy as np
from numpy.typing import NDArray

from abb_emulator.hammer import HammerTaps, tap
from benchmarks.table import Line
from impact_testing import impact_modes, ImpactRecord, ImpactResult
from modal_core.mode import Mode
from modal_core.numbers.indicators import mac
from structural_model import load_layout, load_robot

ROBOT, FIRST_SEED = 'irb6660_205_190', 890_000
POSES = ('P1', 'P2', 'P3')
ASKED_HZ = (100.0, 200.0)
"""Ends of two bands: that of the arm's tests, and what the tip excites above it."""
NEAR, ALIKE = 0.02, 0.5
"""A true mode is found when one lies so near, with a MAC of at least that."""
PEER_ORDER = 60
REACH = {'frequency': 0.2, 'damping': 5.0, 'MAC': 0.98, 'modal mass': 5.0}
COVERAGE = (0.93, 0.97)


@dataclass(frozen=True)
class Truth:
    """Modes of the arm at a pose."""

    frequency_hz: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    shapes: NDArray[np.complex128]
    pole: NDArray[np.complex128]

    def mass(self, mode: int, entry: int) -> float:
        """Return the modal mass of the shape whose given entry is 1 [kg]."""
        return 1.0 / (2.0 * self.pole[mode].imag * abs(self.shapes[entry, mode]) ** 2)


@dataclass(frozen=True)
class Error:
    """One true mode against what was found, NaN where it was not: per cent, MAC, and sigmas."""

    true_hz: float
    values: dict[str, float]
    sigmas: tuple[float, ...] = ()


def tests(seed: int) -> tuple[list[ImpactRecord], Truth]:
    """Tap 14 points five times each, along a random axis of the sensor there."""
    rng = np.random.default_rng(seed)
    model, channels = load_robot(ROBOT), load_layout(ROBOT, 'sensors').channels
    pose = model.pose(POSES[seed % len(POSES)])
    records = []
    for first in range(0, len(channels), 3):
        hit = channels[first + int(rng.integers(3))]
        found = tap(model, pose, channels, hit, HammerTaps(), rng)
        records.append(ImpactRecord(found.force_n, found.responses, found.hit, found.hit))
    true = model.damped_modes(pose, channels)
    return records, Truth(
        true.frequency_hz, true.damping_ratio, true.channel_shapes, true.poles_1_s
    )


def errors_of(truth: Truth, found: ImpactResult) -> tuple[list[Error], int]:
    """Return the errors of all true modes up to the end of the band, and how many are no modes."""
    left, errors = list(found.scaled_modes), []
    for mode, true_hz in enumerate(truth.frequency_hz):
        if true_hz > ASKED_HZ[1]:
            break
        alike = [each for each in left if _is_same(truth, mode, each.mode)]
        if not alike:
            errors.append(Error(float(true_hz), {}))
            continue
        best = min(alike, key=lambda each: abs(each.mode.frequency_hz - true_hz))
        left.remove(best)
        one, true_zeta = best.mode, truth.damping_ratio[mode]
        mass = truth.mass(mode, int(np.argmax(np.abs(one.shape))))
        values = {
            'frequency': 100.0 * abs(one.frequency_hz / true_hz - 1.0),
            'damping': 100.0 * abs(one.damping_ratio / true_zeta - 1.0),
            'MAC': float(mac(one.shape, truth.shapes[:, mode]).item()),
            'modal mass': 100.0 * abs(best.modal_mass_kg / mass - 1.0),
        }
        sigmas = (
            (one.frequency_hz - true_hz) / one.frequency_std_hz,
            (one.damping_ratio - true_zeta) / one.damping_ratio_std,
            (best.modal_mass_kg - mass) / best.modal_mass_std_kg,
        )
        errors.append(Error(float(true_hz), values, tuple(map(float, sigmas))))
    return errors, len(left)


def _is_same(truth: Truth, mode: int, found: Mode) -> bool:
    near = abs(found.frequency_hz / truth.frequency_hz[mode] - 1.0) < NEAR
    return bool(near and mac(found.shape, truth.shapes[:, mode]).item() > ALIKE)


def peer_errors(truth: Truth, found: ImpactResult) -> list[Error]:
    """Return what sdypy-EMA makes of the same FRFs, poles picked at the true frequencies."""
    from sdypy.EMA import Model

    lines = found.points[0].data.frequency_hz
    frf = np.concatenate([point.measured.T for point in found.points])
    model = Model(
        frf=frf,
        freq=lines,
        lower=5.0,
        upper=ASKED_HZ[0] * 1.1,
        pol_order_high=PEER_ORDER,
        frf_form='accelerance',
    )
    model.get_poles(show_progress=False)
    asked = truth.frequency_hz[truth.frequency_hz <= ASKED_HZ[0]]
    model.select_closest_poles(list(asked), f_window=3, fn_temp=0.01, xi_temp=0.1)
    _, residues = model.get_constants()
    residues = np.asarray(residues).reshape(len(found.points), -1, len(asked))
    return [
        _peer_error(truth, found, mode, model.nat_freq[mode], model.nat_xi[mode], residues)
        for mode in range(len(asked))
    ]


def _peer_error(
    truth: Truth,
    found: ImpactResult,
    mode: int,
    f_hz: float,
    zeta: float,
    residues: NDArray[np.complex128],
) -> Error:
    names = found.points[0].data.frf.spectra.names
    own = [names.index(point.hit) for point in found.points]
    best = int(np.argmax([abs(residues[n, place, mode]) for n, place in enumerate(own)]))
    shape = residues[best, :, mode] / np.sqrt(residues[best, own[best], mode] + 0j)
    largest = int(np.argmax(np.abs(shape)))
    omega = 2.0 * np.pi * f_hz * np.sqrt(1.0 - zeta**2)
    mass = 1.0 / (2.0 * omega * abs(shape[largest]) ** 2)
    return Error(
        float(truth.frequency_hz[mode]),
        {
            'frequency': 100.0 * abs(f_hz / truth.frequency_hz[mode] - 1.0),
            'damping': 100.0 * abs(zeta / truth.damping_ratio[mode] - 1.0),
            'MAC': float(mac(shape, truth.shapes[:, mode]).item()),
            'modal mass': 100.0 * abs(mass / truth.mass(mode, largest) - 1.0),
        },
    )


def rows(n_seeds: int) -> Iterator[Line]:
    """Yield the lines of both bands."""
    ours: list[Error] = []
    theirs: list[Error] = []
    n_false = 0
    with_peer = importlib.util.find_spec('sdypy') is not None
    for seed in range(FIRST_SEED, FIRST_SEED + n_seeds):
        records, truth = tests(seed)
        found = impact_modes(records)
        errors, false = errors_of(truth, found)
        ours += errors
        n_false += false
        theirs += peer_errors(truth, found) if with_peer else []
    yield from _lines(ours, theirs, 0.0, ASKED_HZ[0])
    yield from _lines(ours, [], *ASKED_HZ)
    yield Line('modes found that are none', str(n_false), reach='0', met=n_false == 0)


def _lines(ours: list[Error], theirs: list[Error], low: float, high: float) -> Iterator[Line]:
    here = [each for each in ours if low <= each.true_hz < high]
    band = f'{low:.0f} to {high:.0f} Hz'
    n_found = sum(bool(each.values) for each in here)
    yield Line(
        f'{band}: modes found, unattended',
        f'{n_found} of {len(here)}',
        f'{len(theirs)} picked at the true frequencies' if theirs else '-',
        reach='all',
        met=n_found == len(here),
    )
    for name, reach in REACH.items():
        own = _median_and_worst(here, name)
        peer = _median_and_worst(theirs, name)
        met = own[1] >= reach if name == 'MAC' else own[1] <= reach
        sign = '≥' if name == 'MAC' else '≤'
        unit = '' if name == 'MAC' else ' %'
        yield Line(
            f'{band}: {name}{"" if name == "MAC" else " error"}, median and worst',
            _pair(own, unit),
            _pair(peer, unit) if theirs else '-',
            reach=f'{sign} {reach}{unit}',
            met=met,
        )
    sigmas = np.array([value for each in here for value in each.sigmas])
    sigmas = sigmas[np.isfinite(sigmas)]
    share = float(np.mean(np.abs(sigmas) < 2.0)) if len(sigmas) else float('nan')
    yield Line(
        f'{band}: truth within 2σ ({len(sigmas)} values that have one: frequency, damping, mass)',
        f'{100 * share:.1f} %',
        reach='93 to 97 %',
        met=COVERAGE[0] <= share <= COVERAGE[1],
    )


def _median_and_worst(errors: list[Error], name: str) -> tuple[float, float]:
    values = np.array([each.values[name] for each in errors if each.values])
    if not len(values):
        return float('nan'), float('nan')
    worst = values.min() if name == 'MAC' else values.max()
    return float(np.median(values)), float(worst)


def _pair(values: tuple[float, float], unit: str) -> str:
    return ', '.join(f'{value:.4f}' if not unit else f'{value:.3g}{unit}' for value in values)
