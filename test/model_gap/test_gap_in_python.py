"""The gap as a result in Python: names, numbers, files, picture."""

import json

import pytest

import autonomous_modal_analysis as ama
from model_gap.effects.joint_stiffness import JointStiffness
from model_gap.effects.sensor_gain import SensorGain
from model_gap.search import SearchSettings
from test.support.exported_rows import number, rows_of

pytestmark = pytest.mark.slow
SEED = 21
FEWEST = SearchSettings(catalogue=(JointStiffness, SensorGain), most_effects=1)


@pytest.fixture(scope='module')
def told():
    """The fractions done, as they were told."""
    return []


@pytest.fixture(scope='module')
def found(campaign_of, robot, told):
    hidden = [{'type': 'joint_stiffness', 'joint': 'joint_2', 'factor': 0.7}]
    campaign = campaign_of(hidden, SEED)
    return ama.gap(campaign, robot, settings=FEWEST, progress=told.append)


def test_all_is_done_only_at_the_end(found, told):
    assert told[-1] == 1.0 and max(told[:-1]) < 1.0


def test_the_hidden_effect_is_named_with_its_value(found):
    assert found.verdict == 'named', f'seed {SEED}: {found}'
    (effect,) = found.effects
    assert (effect['type'], effect['location']) == ('joint_stiffness', 'joint_2')
    factor = effect['parameters']['factor']
    assert abs(factor['value'] - 0.7) < 4.0 * factor['sigma']
    assert found.gap_after < 0.5 * found.gap_before


def test_its_text_says_verdict_effect_and_gap(found):
    first, *rest = repr(found).splitlines()
    assert first.startswith('named: Joint 2 is ') and '% before' in first
    assert any('joint stiffness at joint_2' in line for line in rest)


def test_its_files_are_its_values(found, tmp_path):
    found.save(tmp_path)
    assert json.loads((tmp_path / 'gap.json').read_text()) == json.loads(found.to_json())
    for name in ('report.html', 'model_updated.yaml'):
        assert (tmp_path / name).stat().st_size > 1000


def test_its_table_is_the_gap_by_place(found):
    table = found.columns()
    assert {'sensor', 'joint', 'mode', 'band', 'pose', 'level', 'record'} == set(table['kind'])
    (place,) = (n for n, name in enumerate(table['name']) if name == 'joint_2')
    assert table['over_noise_after'][place] < table['over_noise_before'][place]
    pytest.importorskip('pandas')
    assert len(found.to_dataframe()) == len(table['kind'])


def test_its_table_goes_into_files(found, tmp_path):
    table = found.columns()
    for ending in ('.csv', '.mat', '.nc'):
        found.export(tmp_path / f'gap{ending}')
        rows = rows_of(tmp_path / f'gap{ending}')
        assert [row['name'] for row in rows] == table['name']
        for name in ('over_noise_before', 'over_noise_after', 'share'):
            assert [number(row[name]) for row in rows] == pytest.approx(table[name], nan_ok=True)
    with pytest.raises(ama.ModalAnalysisError, match='cannot hold this result'):
        found.export(tmp_path / 'gap.uff')


def test_its_picture_shows_before_and_after(found):
    matplotlib = pytest.importorskip('matplotlib')
    matplotlib.use('Agg')
    ax = found.plot_gap('joint')
    assert [label.get_text() for label in ax.get_yticklabels()].count('joint_2') == 1
    with pytest.raises(ama.ModalAnalysisError, match='no such places'):
        found.plot_gap('weather')
    matplotlib.pyplot.close('all')
