"""The pictures of the report: the gap as bars, on the arm, by sensor and band, in spectra."""

import dataclasses
import itertools
import math

from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_reports import (
    Axis,
    Bar,
    bar_chart,
    Curves,
    fixed,
    heat_map,
    percent,
    Trace,
)
from model_gap.campaign import HANN_POWER, record_spectra
from model_gap.comparison import SpectraPair, used_bands
from model_gap.find_gap import GapResult
from model_gap.gap_json import placed_effects
from model_gap.report.arm_picture import arm_picture, TIMES_THE_NOISE

SMOOTHING_HZ = 0.3
FINE_BINS = 1200
PICTURES = 7
TRACES = ('measured', 'measured'), ('before', 'model before'), ('after', 'model after')


def gap_bars(result: GapResult) -> Markup:
    """Draw the gap on held-out and fitted poses, before and after, over the noise."""
    return bar_chart(
        'gap before and after',
        [
            Bar('held out, before', result.gap_before_heldout, 'before'),
            Bar('held out, after', result.gap_after_heldout, 'after'),
            Bar('fitted, before', result.gap_before, 'before'),
            Bar('fitted, after', result.gap_after, 'after'),
        ],
        percent,
        ('noise', result.noise_floor),
    )


def gap_on_arm(result: GapResult) -> Markup:
    """Draw where the gap is, and what it is put down to."""
    search = result.search
    left = {item.name: math.sqrt(item.before) for item in result.where if item.kind == 'sensor'}
    shown_at = {kind.type: kind.shown_at for kind in search.settings.catalogue}
    places = tuple(
        item.location or shown_at.get(item.type, '')
        for effect, others in placed_effects(result)
        for item in (effect, *others)
    )
    pose = search.campaign.records[0].pose
    layout = search.campaign.layout
    return arm_picture(search.model, pose, layout, left, tuple(filter(None, places)))


def gap_map(result: GapResult, shown: list[SpectraPair]) -> Markup:
    """Draw what is left over by sensors and bands, before beside after."""
    names = [channel.name.rsplit('.', 1)[0] for channel in result.search.campaign.layout.channels]
    sensors = list(dict.fromkeys(names))
    bands = used_bands(shown)
    shape = (len(sensors), len(bands))
    before, after, count = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for pair, (column, band) in itertools.product(shown, enumerate(bands)):
        inside = pair.inside(*band)
        one, two = (
            pair.item.squares(pair.item.measured - model)[:, inside]
            for model in (pair.before, pair.after)
        )
        for row, name in enumerate(names):
            place = sensors.index(name)
            before[place, column] += one[row].sum()
            after[place, column] += two[row].sum()
            count[place, column] += (pair.item.seen[row] & inside).sum()
    with np.errstate(invalid='ignore', divide='ignore'):
        before, after = np.sqrt(before / count), np.sqrt(after / count)
    columns = [f'{low:g}–{high:g}' for low, high in bands]
    return heat_map(
        'gap by sensor and band',
        sensors,
        columns,
        [('before', before), ('after', after)],
        TIMES_THE_NOISE,
        lambda value: fixed(value, 1 if value < 100.0 else 0),
    )


def spectra(result: GapResult, shown: list[SpectraPair]) -> list[Curves]:
    """Draw the recording with the largest gap, the sensors in the order of theirs, bin by bin."""
    search = result.search
    channels = search.campaign.layout.channels

    def gap(pair: SpectraPair) -> NDArray[np.float64]:
        squares = pair.item.squares(pair.item.measured - pair.before)
        return np.asarray(squares.mean(axis=1))

    worst = max(shown, key=lambda pair: float(gap(pair).sum()))
    order = np.argsort(-gap(worst))
    item = record_spectra(worst.item.record, search.settings.band, FINE_BINS)
    predictor = dataclasses.replace(search.data.fitting, records=[item])
    (before,) = predictor.predict(search.nominal.cell())
    (after,) = predictor.predict(result.final.cell())
    # From the spectra's own scale to a density: one-sided, and the power a Hann window keeps.
    density = math.sqrt(2.0 / (item.record.sample_rate_hz * HANN_POWER))
    pictures: list[Curves] = []
    seen: set[str] = set()
    for row in order.tolist():
        sensor = channels[row].name.rsplit('.', 1)[0]
        if sensor in seen or row in item.record.missing or len(pictures) == PICTURES:
            continue
        seen.add(sensor)
        smooth = [
            _smoothed(item.frequency_hz, values[row]) for values in (item.measured, before, after)
        ]
        unit = f'({channels[row].unit})/√Hz'
        pictures.append(
            Curves(
                f'{channels[row].name}, {item.record.name}',
                Axis('Frequency', 'Hz'),
                Axis('Amplitude', unit),
                [
                    Trace(kind, hz, density * level, name)
                    for (kind, name), (hz, level) in zip(TRACES, smooth, strict=True)
                ],
                logarithmic=True,
                level=density * float(np.sqrt(np.median(item.noise_power[row]))),
            )
        )
    return pictures


def _smoothed(
    frequency: NDArray[np.float64], values: NDArray[np.complex128]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    edges = np.arange(frequency[0], frequency[-1] + SMOOTHING_HZ, SMOOTHING_HZ)
    place = np.digitize(frequency, edges)
    used = np.unique(place)
    centre = np.array([frequency[place == number].mean() for number in used])
    level = np.array([np.sqrt(np.mean(np.abs(values[place == number]) ** 2)) for number in used])
    return centre, level
