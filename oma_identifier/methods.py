"""The methods by name: the same samples in, the same pole table and mode set out."""

from collections.abc import Callable
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from modal_core.errors import SettingsError
from modal_core.indicators import mac, mpc, mpd, normalise, rotate_to_real
from modal_core.mode import Mode, ModeSet
from modal_core.poles import PoleStatus, PoleTable
from modal_core.samples import Samples
from oma_identifier.bands import Band, plan_bands
from oma_identifier.cluster import Cluster, cluster_poles
from oma_identifier.condition import BandConditioner
from oma_identifier.csi import csi
from oma_identifier.fdd import efdd, fdd
from oma_identifier.identify import check_samples, identify_samples, no_poles
from oma_identifier.plscf import plscf
from oma_identifier.references import choose_references
from oma_identifier.settings import IdentificationSettings
from oma_identifier.ssi_cov import RawPoles
from oma_identifier.ssi_data import ssi_data
from oma_identifier.stabilise import BandPoles, stabilise

BLOCK_ROWS = 20
PLSCF_REFERENCES = 6
PLSCF_LAGS = 512
LEAST_SHARE = 0.5
"""A mode repeats over more than half of the model orders, spurious poles over fewer."""
LEAST_MPC = 0.5
SAMPLES_PER_ORDER = 20


@dataclass(frozen=True, slots=True)
class MethodResult:
    """What a method found.

    Parameters
    ----------
    modes : ModeSet
        By frequency.
    poles : PoleTable
        All poles with the reason each was kept or rejected; empty for FDD and EFDD.
    """

    modes: ModeSet
    poles: PoleTable


Solver = Callable[[NDArray[np.float64], Band, IdentificationSettings], RawPoles]


def identify_by(
    method: str,
    samples: Samples,
    settings: IdentificationSettings | None = None,
    inputs: NDArray[np.float64] | None = None,
) -> MethodResult:
    """Identify the modes of one stretch of samples by the named method.

    Parameters
    ----------
    method : str
        One of :data:`METHODS`.
    samples : Samples
        Responses.
    settings : IdentificationSettings or None
        None: the defaults.
    inputs : (n_samples, n_inputs) array or None
        Known inputs on the grid of the samples; ``csi`` needs them, the others do without.

    Raises
    ------
    SettingsError
        Unknown method, or ``csi`` without inputs.
    IdentificationError
        The samples cannot be identified.
    """
    settings = settings or IdentificationSettings()
    if method not in METHODS:
        raise SettingsError(
            'unknown method', where='method', found=method, expected=', '.join(METHODS)
        )
    if method == 'csi' and inputs is None:
        raise SettingsError('csi needs the known inputs', where='inputs')
    check_samples(samples)
    with threadpool_limits(limits=1):
        return METHODS[method](samples, settings, inputs)


def _by_ssi_cov(
    samples: Samples, settings: IdentificationSettings, _: NDArray[np.float64] | None
) -> MethodResult:
    found = identify_samples(samples, settings)
    return MethodResult(found.modes, found.poles)


def _by_ssi_data(
    samples: Samples, settings: IdentificationSettings, _: NDArray[np.float64] | None
) -> MethodResult:
    return _banded('ssi_data', samples, settings, _solve_ssi_data, None)


def _by_plscf(
    samples: Samples, settings: IdentificationSettings, _: NDArray[np.float64] | None
) -> MethodResult:
    return _banded('plscf', samples, settings, _solve_plscf, None)


def _by_csi(
    samples: Samples, settings: IdentificationSettings, inputs: NDArray[np.float64] | None
) -> MethodResult:
    if inputs is None:
        raise SettingsError('csi needs the known inputs', where='inputs')
    n_inputs = inputs.shape[1]

    def solve(rows: NDArray[np.float64], band: Band, settings: IdentificationSettings) -> RawPoles:
        outputs, known = rows[:, :-n_inputs], rows[:, -n_inputs:]
        references = choose_references(outputs, settings.n_references)
        orders = _orders(rows, settings)
        return csi(outputs, known, references, settings.block_rows or BLOCK_ROWS, orders)

    return _banded('csi', samples, settings, solve, inputs)


def _by_fdd(
    samples: Samples, settings: IdentificationSettings, _: NDArray[np.float64] | None
) -> MethodResult:
    return MethodResult(fdd(samples), no_poles(len(samples.channels)))


def _by_efdd(
    samples: Samples, settings: IdentificationSettings, _: NDArray[np.float64] | None
) -> MethodResult:
    return MethodResult(efdd(samples), no_poles(len(samples.channels)))


METHODS: dict[
    str,
    Callable[[Samples, IdentificationSettings, NDArray[np.float64] | None], MethodResult],
] = {
    'ssi_cov': _by_ssi_cov,
    'ssi_data': _by_ssi_data,
    'plscf': _by_plscf,
    'csi': _by_csi,
    'fdd': _by_fdd,
    'efdd': _by_efdd,
}


def _orders(rows: NDArray[np.float64], settings: IdentificationSettings) -> range:
    highest = min(settings.max_order, len(rows) // SAMPLES_PER_ORDER)
    return range(settings.min_order + settings.min_order % 2, highest + 1, 2)


def _solve_ssi_data(
    rows: NDArray[np.float64], band: Band, settings: IdentificationSettings
) -> RawPoles:
    references = choose_references(rows, settings.n_references)
    block_rows = settings.block_rows or max(
        BLOCK_ROWS, math.ceil(1.5 * settings.max_order / len(references))
    )
    return ssi_data(rows, references, block_rows, _orders(rows, settings))


def _solve_plscf(
    rows: NDArray[np.float64], band: Band, settings: IdentificationSettings
) -> RawPoles:
    references = choose_references(rows, settings.n_references or PLSCF_REFERENCES)
    highest = max(3, 2 * _orders(rows, settings)[-1] // len(references))
    rate = band.sample_rate_hz
    reach = (0.7 * band.low_hz / rate, min(0.49, 1.05 * band.high_hz / rate))
    lags = min(PLSCF_LAGS, len(rows) // 4)
    raw = plscf(rows, references, lags, range(2, highest + 1), reach)
    # Neighbouring orders are two apart for the stabilisation diagram, whatever the references.
    return RawPoles(2 * raw.model_order // len(references), raw.eigenvalue, raw.shape)


def _banded(
    method: str,
    samples: Samples,
    settings: IdentificationSettings,
    solve: Solver,
    inputs: NDArray[np.float64] | None,
) -> MethodResult:
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
        raw = solve(rows, band, settings)
        poles = BandPoles(
            raw.model_order,
            raw.eigenvalue,
            np.asarray(np.log(raw.eigenvalue) * band.sample_rate_hz, dtype=complex),
            raw.shape,
        )
        table, found = _selected(poles, band, settings, scale[:n_channels], len(modes))
        tables.append(table)
        modes += found
    ordered = sorted(modes, key=lambda mode: mode.frequency_hz)
    return MethodResult(
        ModeSet(tuple(ordered), samples.channel_names, method),
        _joined(tables, modes, ordered, n_channels),
    )


def _selected(
    poles: BandPoles,
    band: Band,
    settings: IdentificationSettings,
    scale: NDArray[np.float64],
    n_before: int,
) -> tuple[PoleTable, list[Mode]]:
    status = stabilise(poles, band, settings.max_damping_ratio)
    candidates = np.flatnonzero(status == PoleStatus.KEPT)
    mode_id = np.zeros(len(status), dtype=np.int64)
    least = max(3, math.ceil(LEAST_SHARE * len(np.unique(poles.model_order))))
    status[candidates] = PoleStatus.CLUSTER_OUTLIER
    modes: list[Mode] = []
    clusters = sorted(cluster_poles(poles, candidates), key=len, reverse=True)
    for cluster in clusters:
        if len(cluster) < least:
            status[cluster.members] = PoleStatus.SMALL_CLUSTER
            continue
        mode = _mode_of(poles, cluster, scale)
        if mode.mpc < LEAST_MPC and len(mode.shape) > 1:
            status[cluster.members] = PoleStatus.COMPLEX_SHAPE
            continue
        if any(_same(mode, other) for other in modes):
            continue
        modes.append(mode)
        status[cluster.members] = PoleStatus.KEPT
        mode_id[cluster.members] = n_before + len(modes)
    table = PoleTable(poles.model_order, poles.pole, poles.shape * scale[:, None], status, mode_id)
    return table, modes


def _mode_of(poles: BandPoles, cluster: Cluster, scale: NDArray[np.float64]) -> Mode:
    """Return the cluster's median pole with the shape of its centre."""
    pole = poles.pole[cluster.members]
    shape = normalise(rotate_to_real((poles.shape[:, cluster.centre] * scale)[:, None])[:, 0])
    return Mode(
        frequency_hz=float(np.median(np.abs(pole))) / (2.0 * math.pi),
        damping_ratio=float(np.median(-pole.real / np.abs(pole))),
        shape=shape,
        mpc=float(mpc(shape[:, None])[0]),
        mpd=float(mpd(shape[:, None])[0]),
    )


def _same(first: Mode, second: Mode) -> bool:
    width = max(
        first.damping_ratio * first.frequency_hz, second.damping_ratio * second.frequency_hz
    )
    near = abs(first.frequency_hz - second.frequency_hz) < 2.0 * width
    return near and bool(mac(first.shape, second.shape)[0, 0] > 0.9)


def _joined(
    tables: list[PoleTable], found: list[Mode], ordered: list[Mode], n_channels: int
) -> PoleTable:
    """Join the bands; ids follow the frequency."""
    if not tables:
        return no_poles(n_channels)
    rank = {id(mode): number for number, mode in enumerate(ordered, start=1)}
    renumber = np.array([0, *(rank[id(mode)] for mode in found)])
    return PoleTable(
        np.concatenate([table.model_order for table in tables]),
        np.concatenate([table.pole for table in tables]),
        np.concatenate([table.shape for table in tables], axis=1),
        np.concatenate([table.status for table in tables]),
        renumber[np.concatenate([table.mode_id for table in tables])],
    )
