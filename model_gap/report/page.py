"""One HTML file that shows what was found and needs nothing else to open."""

import dataclasses
import itertools
import math
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_core.atomic_file import write_text
from model_gap.campaign import record_spectra
from model_gap.comparison import compare, Comparison, SensorBand, SpectraPair, used_bands
from model_gap.decide import EVIDENCE_BETWEEN
from model_gap.find_gap import GapResult
from model_gap.gap_json import accepted_effects, gap_mapping
from model_gap.report.arm_picture import arm_picture
from model_gap.report.drawing import gap_bars, gap_map, spectra_plot
from model_gap.report.words import effect_words, headline, percent

HERE = Path(__file__).parent
SMOOTHING_HZ = 0.3
FINE_BINS = 1200
PICTURES = 7
WORST_ROWS = 8
WHOLE = {'payload': 'flange', 'base_compliance': 'base'}


def write_report(result: GapResult, path: Path, comparison: Comparison | None = None) -> None:
    """Write the report, whole or not at all."""
    write_text(path, render_report(result, comparison))


def render_report(result: GapResult, comparison: Comparison | None = None) -> str:
    """Return the report as one HTML document without scripts or links.

    Parameters
    ----------
    result : GapResult
        What was found.
    comparison : Comparison or None
        Its comparison; None: it is made.
    """
    comparison = comparison or compare(result)
    environment = Environment(
        loader=FileSystemLoader(HERE / 'templates'),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    shown = [pair for pair in comparison.pairs if pair.heldout] or list(comparison.pairs)
    pictures = _pictures(result, shown)
    return environment.get_template('gap.html.j2').render(
        title=f'Model gap: {result.search.model.robot_name}',
        verdict=result.decision.verdict.value,
        headline=headline(result),
        effects=effect_words(result),
        decision=result.decision,
        bars=_bars(result),
        arm=_arm(result),
        places=_map(result, shown),
        first=pictures[0] if pictures else '',
        pictures=pictures[1:],
        gap=gap_mapping(result, comparison),
        worst=_worst_sensors(comparison),
        percent=percent,
        evidence_to_add=result.search.settings.worth_adding,
        evidence_between=EVIDENCE_BETWEEN,
    )


def _bars(result: GapResult) -> Markup:
    return gap_bars(
        [
            ('held out, before', result.gap_before_heldout),
            ('held out, after', result.gap_after_heldout),
            ('fitted, before', result.gap_before),
            ('fitted, after', result.gap_after),
        ],
        result.noise_floor,
    )


def _arm(result: GapResult) -> Markup:
    search = result.search
    left = {item.name: math.sqrt(item.before) for item in result.where if item.kind == 'sensor'}
    places = tuple(item.location or WHOLE.get(item.type, '') for item in accepted_effects(result))
    pose = search.campaign.records[0].pose
    layout = search.campaign.layout
    return arm_picture(search.model, pose, layout, left, tuple(filter(None, places)))


def _worst_sensors(comparison: Comparison) -> list[dict[str, object]]:
    """Return the rows of the comparison that were farthest off before."""

    def off(item: SensorBand) -> float:
        size = abs(math.log(max(item.before.magnitude, 1e-6)))
        return size + abs(item.before.phase_rad)

    rows = [item for item in comparison.sensors if item.measured > 2.0 * item.noise]
    return [
        {
            'sensor': item.sensor,
            'band': f'{item.low_hz:g}–{item.high_hz:g}',
            'measured': item.measured,
            'predicted_before': item.predicted_before,
            'predicted_after': item.predicted_after,
            'level_sigma_db': item.level_sigma_db,
            'before': item.before,
            'after': item.after,
        }
        for item in sorted(rows, key=lambda item: -off(item))[:WORST_ROWS]
    ]


def _map(result: GapResult, shown: list[SpectraPair]) -> Markup:
    names = [channel.name.rsplit('.', 1)[0] for channel in result.search.campaign.layout.channels]
    sensors = list(dict.fromkeys(names))
    bands = used_bands(shown)
    shape = (len(sensors), len(bands))
    before, after, count = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for pair, (column, band) in itertools.product(shown, enumerate(bands)):
        inside = pair.inside(*band)
        noise = pair.item.noise_power[:, inside]
        measured = pair.item.measured[:, inside]
        one = np.abs(measured - pair.before[:, inside]) ** 2 / noise
        two = np.abs(measured - pair.after[:, inside]) ** 2 / noise
        for row, name in enumerate(names):
            place = sensors.index(name)
            before[place, column] += one[row].sum()
            after[place, column] += two[row].sum()
            count[place, column] += inside.sum()
    with np.errstate(invalid='ignore', divide='ignore'):
        before, after = np.sqrt(before / count), np.sqrt(after / count)
    columns = [f'{low:g}–{high:g}' for low, high in bands]
    return gap_map(sensors, columns, before, after)


def _pictures(result: GapResult, shown: list[SpectraPair]) -> list[Markup]:
    """Draw the recording with the largest gap, the sensors in the order of theirs, bin by bin."""
    search = result.search
    channels = search.campaign.layout.channels

    def gap(pair: SpectraPair) -> NDArray[np.float64]:
        squares = np.abs(pair.item.measured - pair.before) ** 2 / pair.item.noise_power
        return np.asarray(squares.mean(axis=1))

    worst = max(shown, key=lambda pair: float(gap(pair).sum()))
    order = np.argsort(-gap(worst))
    item = record_spectra(worst.item.record, search.settings.band, FINE_BINS)
    predictor = dataclasses.replace(search.data.fitting, records=[item])
    (before,) = predictor.predict(search.nominal.setup())
    (after,) = predictor.predict(result.final.setup())
    pictures: list[Markup] = []
    seen: set[str] = set()
    for row in order.tolist():
        sensor = channels[row].name.rsplit('.', 1)[0]
        if sensor in seen or len(pictures) == PICTURES:
            continue
        seen.add(sensor)
        smooth = [
            _smoothed(item.frequency_hz, values[row]) for values in (item.measured, before, after)
        ]
        pictures.append(
            spectra_plot(
                f'{channels[row].name}, {item.record.name}',
                smooth[0][0],
                [
                    (name, level)
                    for name, (_, level) in zip(
                        ('measured', 'before', 'after'), smooth, strict=True
                    )
                ],
                float(np.sqrt(np.median(item.noise_power[row]))),
                (460, 210) if pictures else (920, 300),
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
