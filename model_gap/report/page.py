"""One HTML file that shows what was found and needs nothing else to open."""

import itertools
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup
import numpy as np
from numpy.typing import NDArray

from modal_core.atomic_file import write_text
from model_gap.find_gap import GapResult
from model_gap.gap_json import gap_mapping
from model_gap.locate import BAND_EDGES_HZ, measured_and_predicted
from model_gap.report.drawing import gap_bars, gap_map, spectra_plot
from model_gap.report.words import effect_words, headline, percent

HERE = Path(__file__).parent
SMOOTHING_HZ = 0.4
PICTURES = 6


def write_report(result: GapResult, path: Path) -> None:
    """Write the report, whole or not at all."""
    write_text(path, render_report(result))


def render_report(result: GapResult) -> str:
    """Return the report as one HTML document without scripts or links."""
    environment = Environment(
        loader=FileSystemLoader(HERE / 'templates'),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template('gap.html.j2').render(
        title=f'Model gap: {result.search.model.robot_name}',
        verdict=result.decision.verdict.value,
        headline=headline(result),
        effects=effect_words(result),
        decision=result.decision,
        bars=_bars(result),
        places=_map(result),
        pictures=_pictures(result),
        gap=gap_mapping(result),
        percent=percent,
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


def _map(result: GapResult) -> Markup:
    search = result.search
    names = [channel.name.rsplit('.', 1)[0] for channel in search.campaign.layout.channels]
    sensors = list(dict.fromkeys(names))
    shape = (len(sensors), len(BAND_EDGES_HZ) - 1)
    before, after, count = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    predictor = search.heldout if search.heldout.records else search.fitting
    pairs = zip(
        predictor.records,
        measured_and_predicted(predictor, search.nominal),
        measured_and_predicted(predictor, result.final),
        strict=True,
    )
    for item, (measured, nominal), (_, fitted) in pairs:
        bands = np.digitize(item.frequency_hz, BAND_EDGES_HZ) - 1
        for row, name in enumerate(names):
            place = sensors.index(name)
            for band in range(shape[1]):
                chosen = bands == band
                power = item.noise_power[row, chosen]
                before[place, band] += _power(
                    (measured[row, chosen] - nominal[row, chosen]) / np.sqrt(power)
                )
                after[place, band] += _power(
                    (measured[row, chosen] - fitted[row, chosen]) / np.sqrt(power)
                )
                count[place, band] += chosen.sum()
    with np.errstate(invalid='ignore', divide='ignore'):
        before, after = before / count, after / count
    seen = np.any(count > 0.0, axis=0)
    columns = [f'{low:g}–{high:g}' for low, high in itertools.pairwise(BAND_EDGES_HZ)]
    kept = [name for name, used in zip(columns, list(seen), strict=True) if used]
    return gap_map(sensors, kept, before[:, seen], after[:, seen])


def _pictures(result: GapResult) -> list[Markup]:
    """Draw the held-out channels where the gap was largest."""
    search = result.search
    predictor = search.heldout if search.heldout.records else search.fitting
    nominal = measured_and_predicted(predictor, search.nominal)
    fitted = measured_and_predicted(predictor, result.final)
    found = []
    for number, item in enumerate(predictor.records):
        residual = np.abs(nominal[number][0] - nominal[number][1]) ** 2
        for row, channel in enumerate(search.campaign.layout.channels):
            found.append(
                (float((residual[row] / item.noise_power[row]).sum()), number, row, channel)
            )
    found.sort(key=lambda entry: -entry[0])
    seen: set[str] = set()
    pictures: list[Markup] = []
    for _, number, row, channel in found:
        if channel.name in seen or len(pictures) == PICTURES:
            continue
        seen.add(channel.name)
        item = predictor.records[number]
        frequency, measured = _smoothed(item.frequency_hz, nominal[number][0][row])
        _, before = _smoothed(item.frequency_hz, nominal[number][1][row])
        _, after = _smoothed(item.frequency_hz, fitted[number][1][row])
        pictures.append(
            spectra_plot(
                f'{channel.name}, {item.record.name}',
                frequency,
                [('measured', measured), ('before', before), ('after', after)],
                float(np.sqrt(np.median(item.noise_power[row]))),
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


def _power(values: NDArray[np.complex128]) -> float:
    return float(np.sum(np.abs(values) ** 2))
