"""Stages that are switched off: they exist, and are on again afterwards."""

import pytest

from benchmarks.ablation.shared import Shared, verdict_of
from benchmarks.ablation.stages import place_of, STAGES_OFF
from benchmarks.ablation.table import rows_of, WHOLE
from benchmarks.families.drawing import draw
from benchmarks.families.family import FAMILIES


@pytest.mark.parametrize('stage', STAGES_OFF, ids=lambda stage: stage.name)
def test_what_a_stage_replaces_is_there(stage):
    for name in stage.off:
        where, attribute = place_of(name)
        assert hasattr(where, attribute), name


def test_a_stage_is_off_for_one_run_and_results_are_not_mixed_up():
    record, shared = draw(FAMILIES['few'], 20), Shared()
    whole = verdict_of(record, None, shared)
    assert sum(whole.found) == 2 and not whole.failed
    by_name = {stage.name: stage for stage in STAGES_OFF}
    plain = verdict_of(record, by_name['refinement'], shared)
    assert plain.errors != whole.errors and plain.shapes != whole.shapes
    unpooled = verdict_of(record, by_name['tails of other modes'], shared)
    assert unpooled.errors != whole.errors
    assert verdict_of(record, None, shared).errors == whole.errors
    assert verdict_of(record, None, Shared()).errors == whole.errors


def test_a_stage_pays_where_records_lose_without_it():
    def entry(stage: str, seed: int, n_found: int, n_false: int) -> dict:
        verdict = {
            'family': 'plain',
            'seed': seed,
            'found': [0, 0, n_found],
            'errors': [],
            'inside': [],
            'shapes': [],
            'n_false': n_false,
            'n_lines_as_modes': 0,
            'n_false_lines': 0,
        }
        return {'stage': stage, 'verdict': verdict}

    entries = [entry(WHOLE, seed, 5, 0) for seed in range(20)]
    entries += [entry('told apart', seed, 5, seed % 2) for seed in range(20)]
    entries += [entry('poles agree', seed, 5 + seed % 2, 0) for seed in range(20)]
    rows, n_records = rows_of(entries)
    assert n_records == 20
    assert [row[-1] for row in rows] == ['', 'yes', '']
    assert rows[1][1] == '10 of 20'
