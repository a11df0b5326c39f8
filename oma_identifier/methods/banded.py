"""Methods that solve every frequency band afresh from conditioned samples."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
import math

import numpy as np
from numpy.typing import NDArray

from modal_core.indicators import mac, mpc, mpd, normalise, rotate_to_real
from modal_core.mode import Mode, ModeSet
from modal_core.poles import PoleStatus, PoleTable
from modal_core.samples import Samples
from oma_identifier.covariance import Band, BandConditioner, choose_references, plan_bands
from oma_identifier.identify import no_poles
from oma_identifier.methods import plscf
from oma_identifier.methods.half_spectra import LagSums
from oma_identifier.methods.jackknife import jackknife
from oma_identifier.selection import BandPoles, Cluster, cluster_poles, stabilise
from oma_identifier.settings import IdentificationSettings
from oma_identifier.subspace import combined_gram, combined_poles, data_gram, data_poles, RawPoles

BLOCK_ROWS = 20
PLSCF_REFERENCES = 6
PLSCF_LAGS = 512
LEAST_SHARE = 0.5
"""A mode repeats over more than half of the model orders, spurious poles over fewer."""
LEAST_MPC = 0.5
NEAR, SAME_MAC = 2.0, 0.9
"""Two poles nearer to each other, in half-widths, and of shapes more alike are one mode."""
SAMPLES_PER_ORDER = 20
WIDEST, FROM_LIMIT = 0.7, 6.0
"""Largest deviation in half-widths of the peak, and in multiples of the least any method has."""
STILL = 1e-3
"""Share of the strongest input below which another does not move in a band."""

Real = NDArray[np.float64]
Solve = Callable[[range, tuple[int, int] | None], RawPoles]
"""Even model orders, and first and last row of a stretch to leave out, to poles."""


@dataclass(frozen=True, slots=True)
class Problem:
    """One band, ready to be solved.

    Parameters
    ----------
    rows : (n_samples, n_columns) array
        Conditioned responses, then inputs; each of unit root mean square.
    n_channels : int
        Columns that are responses.
    band : Band
        Which band.
    orders : range
        Even model orders.
    """

    rows: Real
    n_channels: int
    band: Band
    orders: range


Solver = Callable[[Problem, IdentificationSettings], Solve]
"""Sums what a method needs of the rows, once per band; what it returns solves."""


def by_ssi_data(problem: Problem, settings: IdentificationSettings) -> Solve:
    """Prepare data-driven subspace identification."""
    references = choose_references(problem.rows, settings.n_references)
    block_rows = settings.block_rows or max(
        BLOCK_ROWS, math.ceil(1.5 * settings.max_order / len(references))
    )
    gram = data_gram(problem.rows, references, block_rows)

    def solve(orders: range, left_out: tuple[int, int] | None) -> RawPoles:
        return data_poles(gram.without(left_out), references, block_rows, orders)

    return solve


def by_csi(problem: Problem, settings: IdentificationSettings) -> Solve:
    """Prepare combined subspace identification; a band without inputs is solved without."""
    outputs, inputs = problem.rows[:, : problem.n_channels], problem.rows[:, problem.n_channels :]
    inputs = inputs[:, inputs.any(axis=0)]
    if not inputs.size:
        return by_ssi_data(replace(problem, rows=outputs), settings)
    references = choose_references(outputs, settings.n_references)
    block_rows = settings.block_rows or BLOCK_ROWS
    gram = combined_gram(outputs, inputs, block_rows)

    def solve(orders: range, left_out: tuple[int, int] | None) -> RawPoles:
        rest = gram.without(left_out)
        return combined_poles(rest, inputs.shape[1], references, block_rows, orders)

    return solve


def by_plscf(problem: Problem, settings: IdentificationSettings) -> Solve:
    """Prepare poly-reference least squares; its polynomial order counts twice."""
    references = choose_references(problem.rows, settings.n_references or PLSCF_REFERENCES)
    band, rate = problem.band, problem.band.sample_rate_hz
    reach = (0.7 * band.low_hz / rate, min(0.49, 1.05 * band.high_hz / rate))
    sums = LagSums(problem.rows, references, min(PLSCF_LAGS, len(problem.rows) // 4))
    highest = max(3, 2 * problem.orders[-1] // len(references))

    def solve(orders: range, left_out: tuple[int, int] | None) -> RawPoles:
        # A polynomial order has a pole pair for every two references.
        first, last = orders[0] // 2, orders[-1] // 2
        degrees = range(max(2, first), min(last, highest) + 1)
        if len(orders) == 1:
            degrees = range(first, first + 1)
        raw = plscf.from_covariance(sums.covariance(left_out), degrees, reach)
        return RawPoles(2 * raw.model_order // len(references), raw.eigenvalue, raw.shape)

    return solve


def banded(
    method: str,
    samples: Samples,
    settings: IdentificationSettings,
    solver: Solver,
    inputs: Real | None = None,
) -> tuple[ModeSet, PoleTable]:
    """Condition and solve every frequency band, select, and join."""
    tables: list[PoleTable] = []
    modes: list[Mode] = []
    data = samples.acceleration
    if inputs is not None:
        data = np.concatenate([data, inputs], axis=1)
    n_channels = len(samples.channels)
    for band in plan_bands(samples.sample_rate_hz, samples.duration_s, settings):
        rows = BandConditioner(band)(data)
        if len(rows) < 10 * SAMPLES_PER_ORDER:
            continue
        scale = rows.std(axis=0)
        rows = np.divide(rows, scale, out=np.zeros_like(rows), where=scale > 0.0)
        if inputs is not None:
            rows[:, n_channels:][:, scale[n_channels:] <= STILL * inputs.std(axis=0).max()] = 0.0
        problem = Problem(rows, n_channels, band, _orders(rows, settings))
        solve = solver(problem, settings)
        raw = solve(problem.orders, None)
        poles = BandPoles(
            raw.model_order,
            raw.eigenvalue,
            np.asarray(np.log(raw.eigenvalue) * band.sample_rate_hz, dtype=complex),
            raw.shape,
        )
        status, clusters = _selected(poles, band, settings)
        mode_id = np.zeros(len(status), dtype=np.int64)
        for cluster, deviation in _determined(problem, solve, poles, clusters, status):
            modes.append(_mode_of(poles, cluster, scale[:n_channels], deviation))
            mode_id[cluster.members] = len(modes)
        shape = poles.shape * scale[:n_channels, None]
        tables.append(PoleTable(poles.model_order, poles.pole, shape, status, mode_id))
    ordered = sorted(_distinct(modes), key=lambda mode: mode.frequency_hz)
    table = _joined(tables, modes, ordered, n_channels)
    return ModeSet(tuple(ordered), samples.channel_names, method), table


def _orders(rows: Real, settings: IdentificationSettings) -> range:
    highest = min(settings.max_order, len(rows) // SAMPLES_PER_ORDER)
    return range(settings.min_order + settings.min_order % 2, highest + 1, 2)


def _selected(
    poles: BandPoles, band: Band, settings: IdentificationSettings
) -> tuple[NDArray[np.uint8], list[Cluster]]:
    status = stabilise(poles, band, settings.max_damping_ratio)
    candidates = np.flatnonzero(status == PoleStatus.KEPT)
    least = max(3, math.ceil(LEAST_SHARE * len(np.unique(poles.model_order))))
    status[candidates] = PoleStatus.CLUSTER_OUTLIER
    found: list[Cluster] = []
    for cluster in sorted(cluster_poles(poles, candidates), key=len, reverse=True):
        shape = poles.shape[:, [cluster.centre]]
        if len(cluster) < least:
            status[cluster.members] = PoleStatus.SMALL_CLUSTER
        elif len(shape) > 1 and mpc(shape)[0] < LEAST_MPC:
            status[cluster.members] = PoleStatus.COMPLEX_SHAPE
        elif not any(_same(poles, cluster, other) for other in found):
            found.append(cluster)
            status[cluster.members] = PoleStatus.KEPT
    return status, found


def _determined(
    problem: Problem,
    solve: Solve,
    poles: BandPoles,
    found: list[Cluster],
    status: NDArray[np.uint8],
) -> list[tuple[Cluster, Real]]:
    """Return the clusters that the data determine, with relative standard deviations."""
    kept: list[tuple[Cluster, Real]] = []
    left = list(found)
    while left:
        # The model order that shows most of the modes, the lowest of such.
        orders = np.concatenate([poles.model_order[cluster.members] for cluster in left])
        order = int(np.argmax(np.bincount(orders)))
        here = [c for c in left if order in poles.model_order[c.members]]
        left = [c for c in left if not any(c is other for other in here)]
        rows = np.array([c.members[poles.model_order[c.members] == order][0] for c in here])
        deviation = jackknife(
            problem.rows[:, : problem.n_channels],
            partial(solve, range(order, order + 1, 2)),
            np.log(poles.eigenvalue[rows]),
            poles.shape[:, rows],
        )
        duration_s = len(problem.rows) / problem.band.sample_rate_hz
        for cluster, row, own in zip(here, rows, deviation.T, strict=True):
            if _is_determined(poles.pole[row], own, duration_s):
                kept.append((cluster, own))
            else:
                status[cluster.members] = PoleStatus.UNCERTAIN
    return kept


def _is_determined(pole: complex, deviation: Real, duration_s: float) -> bool:
    """Tell whether a peak is narrower than its own blur, and as sharp as the record allows."""
    damping = -pole.real / abs(pole)
    blur = max(deviation[0] / damping, deviation[1])
    limit = 1.0 / math.sqrt(-pole.real * duration_s)
    return bool(blur < min(WIDEST, FROM_LIMIT * limit))


def _mode_of(poles: BandPoles, cluster: Cluster, scale: Real, deviation: Real) -> Mode:
    """Return the cluster's median pole with the shape of its centre."""
    pole = poles.pole[cluster.members]
    shape = normalise(rotate_to_real((poles.shape[:, cluster.centre] * scale)[:, None])[:, 0])
    frequency_hz = float(np.median(np.abs(pole))) / (2.0 * math.pi)
    damping_ratio = float(np.median(-pole.real / np.abs(pole)))
    return Mode(
        frequency_hz=frequency_hz,
        damping_ratio=damping_ratio,
        shape=shape,
        frequency_std_hz=float(deviation[0]) * frequency_hz,
        damping_ratio_std=float(deviation[1]) * damping_ratio,
        mpc=float(mpc(shape[:, None])[0]),
        mpd=float(mpd(shape[:, None])[0]),
    )


def _same(poles: BandPoles, first: Cluster, second: Cluster) -> bool:
    one, other = poles.pole[first.centre], poles.pole[second.centre]
    near = abs(one.imag - other.imag) < NEAR * max(-one.real, -other.real)
    shapes = poles.shape[:, [first.centre, second.centre]]
    return near and bool(mac(shapes[:, 0], shapes[:, 1])[0, 0] > SAME_MAC)


def _distinct(modes: list[Mode]) -> list[Mode]:
    """Return one of each mode that two bands found where they overlap: the better determined."""
    kept: list[Mode] = []
    for mode in sorted(modes, key=lambda mode: mode.frequency_std_hz / mode.frequency_hz):
        width_hz = mode.damping_ratio * mode.frequency_hz
        if not any(
            abs(mode.frequency_hz - other.frequency_hz)
            < NEAR * max(width_hz, other.damping_ratio * other.frequency_hz)
            and mac(mode.shape, other.shape)[0, 0] > SAME_MAC
            for other in kept
        ):
            kept.append(mode)
    return kept


def _joined(
    tables: list[PoleTable], found: list[Mode], ordered: list[Mode], n_channels: int
) -> PoleTable:
    """Join the bands; ids follow the frequency."""
    if not tables:
        return no_poles(n_channels)
    rank = {id(mode): number for number, mode in enumerate(ordered, start=1)}
    renumber = np.array([0, *(rank.get(id(mode), 0) for mode in found)])
    mode_id = renumber[np.concatenate([table.mode_id for table in tables])]
    status = np.concatenate([table.status for table in tables])
    status[(status == PoleStatus.KEPT) & (mode_id == 0)] = PoleStatus.CLUSTER_OUTLIER
    return PoleTable(
        np.concatenate([table.model_order for table in tables]),
        np.concatenate([table.pole for table in tables]),
        np.concatenate([table.shape for table in tables], axis=1),
        status,
        mode_id,
    )
