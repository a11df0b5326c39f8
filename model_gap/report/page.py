"""One HTML file that shows what was found and needs nothing else to open."""

import math
from pathlib import Path

from modal_core.files.atomic_file import write_text
from modal_reports import (
    capital,
    curves_data,
    fixed,
    Page,
    render,
)
from model_gap.calibration import calibration, calibration_words, encoder_words, mounts
from model_gap.comparison import compare_model, ModelComparison, SensorBand
from model_gap.decide import Verdict
from model_gap.find_gap import GapResult
from model_gap.gap_json import gap_mapping
from model_gap.report.comparison_tables import (
    amplitude_table,
    lines_table,
    modes_table,
    transmissibility_table,
)
from model_gap.report.least_seen_words import least_seen_words
from model_gap.report.pictures import gap_bars, gap_map, gap_on_arm, spectra
from model_gap.report.tables import candidates_table, where_table
from model_gap.report.words import effect_words, gravity_words, headline, named_springs
from model_gap.search import EVIDENCE_BETWEEN

HERE = Path(__file__).parent
TEMPLATE = HERE / 'templates' / 'gap.html.j2'
STYLES = (HERE / 'templates' / 'gap.css',)
WORST_ROWS = 8


def write_report(result: GapResult, path: Path, comparison: ModelComparison | None = None) -> None:
    """Write the report, whole or not at all."""
    write_text(path, render_report(result, comparison))


def render_report(result: GapResult, comparison: ModelComparison | None = None) -> str:
    """Return the report as one HTML document without links.

    Parameters
    ----------
    result : GapResult
        What was found.
    comparison : ModelComparison or None
        Its comparison; None: it is made.
    """
    comparison = comparison or compare_model(result)
    shown = [pair for pair in comparison.pairs if pair.heldout] or list(comparison.pairs)
    pictures = spectra(result, shown)
    values = {
        'verdict': result.decision.verdict.value,
        'headline': headline(result),
        'effects': effect_words(result),
        'decision': result.decision,
        'bars': gap_bars(result),
        'arm': gap_on_arm(result),
        'places': gap_map(result, shown),
        'pictures': range(len(pictures)),
        'capital': capital,
        'gravity': gravity_words(result),
        'least_seen': least_seen_words(result.least_seen),
        'calibration': [
            *calibration_words(calibration(result), mounts(result), named_springs(result)),
            *encoder_words(result),
        ],
        **_tables(result, comparison),
    }
    title = f'Model gap: {result.search.model.robot_name}'
    charts = {'curves': [curves_data(each) for each in pictures]}
    return render(Page('Model gap report', title, TEMPLATE, values, charts, STYLES))


def _tables(result: GapResult, comparison: ModelComparison) -> dict[str, object]:
    gap = gap_mapping(result, comparison)
    compared = gap['comparison']
    modes = compared['modes']
    first = [row for row in modes if row['record'] == modes[0]['record']]
    more = len(first) < len(modes)
    return {
        'gap': gap,
        'candidates': candidates_table(
            gap['candidates'],
            result.search.settings.worth_adding,
            EVIDENCE_BETWEEN,
            result.decision.verdict is Verdict.UNEXPLAINED,
        ),
        'parts': where_table(gap['where'], ('joint', 'mode', 'band', 'level')),
        'records': where_table(gap['where'], ('sensor', 'pose', 'record')),
        'modes': modes_table(first, 'modes of one recording'),
        'more_modes': modes_table(modes, 'modes of all recordings') if more else None,
        'sensors': transmissibility_table(_worst_sensors(comparison)),
        'amplitude': amplitude_table(compared['amplitude_dependence']),
        'lines': lines_table(compared['lines']),
        'excitation': compared['excitation']['statement'],
        'tolerances': ', '.join(
            f'{item["name"]} {fixed(item["deviations"], 1, sign=True)}'
            for item in gap['tolerances']
        ),
    }


def _worst_sensors(comparison: ModelComparison) -> list[SensorBand]:
    """Return the rows of the comparison that were farthest off before."""

    def off(item: SensorBand) -> float:
        size = abs(math.log(max(item.before.magnitude, 1e-6)))
        return size + abs(item.before.phase_rad)

    rows = [item for item in comparison.sensors if item.measured > 2.0 * item.noise]
    return sorted(rows, key=lambda item: -off(item))[:WORST_ROWS]
