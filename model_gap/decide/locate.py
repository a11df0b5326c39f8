"""Where the gap is: by sensor, joint, mode, band, pose, level and record, before and after."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import itertools

import numpy as np

from modal_core.channel import Channel
from model_gap.campaign import CAMPAIGN
from model_gap.cell import in_words
from model_gap.fit import pose_groups
from model_gap.hypothesis import Hypothesis
from model_gap.predict import Predictor
from model_gap.search import joint_shares, Search

NEAR_MODE = 0.12
KINDS = ('sensor', 'joint', 'mode', 'band', 'pose', 'level', 'record')


@dataclass(frozen=True)
class Where:
    """The gap of one part of the data.

    Parameters
    ----------
    kind, name : str
        ``sensor``, ``joint``, ``mode``, ``band``, ``pose``, ``level`` or ``record``.
    before, after : float
        χ with the nominal model, and with what was found; of a joint, the part of χ that a torque
        there would account for, whatever its law (the parts overlap).
    share : float
        Of the whole gap before.
    """

    kind: str
    name: str
    before: float
    after: float
    share: float


def locate(search: Search, after: Hypothesis) -> tuple[Where, ...]:
    """Return the table of places, the largest share of the gap first in every kind."""
    parts = []
    for predictor in (search.data.fitting, search.data.heldout):
        if not predictor.records:
            continue
        before = predictor.squares(search.nominal.cell())
        left = predictor.squares(after.cell())
        parts += [
            (item, one, two)
            for item, one, two in zip(predictor.records, before, left, strict=True)
        ]
    channels = search.campaign.layout.channels
    total = sum(float(one.sum()) for _, one, _ in parts)
    table = []
    for kind, names, pick in _kinds(search, channels, after):
        for name in names:
            chosen = [(pick(item, one, name), pick(item, two, name)) for item, one, two in parts]
            count = sum(np.count_nonzero(pick(item, item.seen, name)) for item, *_ in parts)
            if not count:
                continue
            before_sum = sum(float(one.sum()) for one, _ in chosen)
            after_sum = sum(float(two.sum()) for _, two in chosen)
            table.append(
                Where(kind, name, before_sum / count, after_sum / count, before_sum / total)
            )
    table += _joints(search, after)
    order = {kind: number for number, kind in enumerate(KINDS)}
    return tuple(sorted(table, key=lambda item: (order[item.kind], -item.share)))


def _joints(search: Search, after: Hypothesis) -> list[Where]:
    before, left = (joint_shares(item, search.data.fitting) for item in (search.nominal, after))
    return [
        Where(
            'joint',
            in_words(place),
            part / before.count,
            left.explained[place] / left.count,
            part / before.total,
        )
        for place, part in before.explained.items()
    ]


def _modes(search: Search, hypothesis: Hypothesis) -> dict[int, np.ndarray]:
    """Return the mode nearest to every bin, per record; -1 far from all."""
    cell = hypothesis.cell()
    nearest = {}
    for predictor in (search.data.fitting, search.data.heldout):
        if not predictor.records:
            continue
        systems = predictor.systems(cell.spec, cell.channels)
        for item, group in zip(predictor.records, predictor.groups, strict=True):
            poles = systems[group].poles
            own = np.sort(np.abs(poles[poles.imag > 0.0])) / (2.0 * np.pi)
            distance = np.abs(np.log(item.frequency_hz[:, None] / own))
            place = np.argmin(distance, axis=1)
            place[distance.min(axis=1) > NEAR_MODE] = -1
            nearest[id(item)] = place
    return nearest


Pick = Callable[..., np.ndarray]


def _kinds(
    search: Search, channels: Sequence[Channel], after: Hypothesis
) -> list[tuple[str, list[str], Pick]]:
    sensors = [channel.name.rsplit('.', 1)[0] for channel in channels]
    empty = np.zeros((0, 0))

    def by_record(item, squares, name):  # type: ignore[no-untyped-def]
        return squares if item.record.name == name else empty

    def by_level(item, squares, name):  # type: ignore[no-untyped-def]
        return squares if item.record.level == name else empty

    def by_sensor(item, squares, name):  # type: ignore[no-untyped-def]
        return squares[[number for number, other in enumerate(sensors) if other == name]]

    def by_band(item, squares, name):  # type: ignore[no-untyped-def]
        low, high = (float(edge) for edge in name.removesuffix(' Hz').split('-'))
        inside = (item.frequency_hz >= low) & (item.frequency_hz < high)
        return squares[:, inside]

    nearest = _modes(search, after)
    count = max(int(place.max(initial=-1)) for place in nearest.values()) + 1

    def by_mode(item, squares, name):  # type: ignore[no-untyped-def]
        return squares[:, nearest[id(item)] == int(name.split()[1]) - 1]

    groups = pose_groups(search.campaign)
    pose_of = {
        record.name: f'pose {group + 1}'
        for record, group in zip(search.campaign.records, groups, strict=True)
    }

    def by_pose(item, squares, name):  # type: ignore[no-untyped-def]
        return squares if pose_of[item.record.name] == name else empty

    records = list(dict.fromkeys(item.name for item in search.campaign.records))
    levels = list(dict.fromkeys(item.level for item in search.campaign.records))
    bands = [f'{low:g}-{high:g} Hz' for low, high in itertools.pairwise(CAMPAIGN.band_edges_hz)]
    return [
        ('sensor', list(dict.fromkeys(sensors)), by_sensor),
        ('band', bands, by_band),
        ('mode', [f'mode {number + 1}' for number in range(count)], by_mode),
        ('pose', list(dict.fromkeys(pose_of.values())), by_pose),
        ('level', levels, by_level),
        ('record', records, by_record),
    ]


def gap_fraction(predictor: Predictor, hypothesis: Hypothesis) -> float:
    """Return the gap as a fraction of the response, √(Σ|Y-Ŷ|²/σ² / Σ|Y|²/σ²)."""
    if not predictor.records:
        return float('nan')
    residual = sum(float(part.sum()) for part in predictor.squares(hypothesis.cell()))
    return float(np.sqrt(residual / _response(predictor)))


def noise_floor(predictor: Predictor) -> float:
    """Return the gap that noise alone would make, as a fraction of the response."""
    if not predictor.records:
        return float('nan')
    count = sum(item.count for item in predictor.records)
    return float(np.sqrt(count / _response(predictor)))


def _response(predictor: Predictor) -> float:
    return sum(float(np.sum(item.squares(item.measured))) for item in predictor.records)
