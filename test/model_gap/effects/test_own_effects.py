"""Effects of one's own: found like the others, and a broken one is one line with its place."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
import yaml

import autonomous_modal_analysis as ama
from modal_core.errors import ModelError, SettingsError
from modal_core.files.share import share_path
from model_gap.cell.cell_model import CellModel
from model_gap.effects import CATALOGUE, Scene, with_own_effects
from model_gap.effects.sensor_delay import SensorDelay
from model_gap.effects.sensor_mount_resonance import SensorMountResonance
from model_gap.hypothesis.known_effects import with_known_effects
from model_gap.report import summary_lines
from model_gap.search import SearchSettings
from structural_model import load_robot
from structural_model.description import KnownEffect, KnownNumber
from test.support.docs_pages import blocks, DOCS
from test.support.hidden_campaign import make_campaign, SENSORS
from test.support.write_campaign import write_campaign

ROBOT = share_path('config', 'robots', 'irb6660_205_190')
SEED = 41
(CODE,) = [
    block.text for block in blocks(DOCS / 'howto' / 'add_effect.md') if block.language == 'python'
]


@pytest.fixture
def folder(tmp_path):
    place = tmp_path / 'mine'
    place.mkdir()
    (place / 'low_pass.py').write_text(CODE)
    return place


def test_the_example_of_the_documents_is_thirty_lines():
    assert len(CODE.splitlines()) <= 36


def test_it_stands_beside_the_others(folder):
    catalogue = with_own_effects(CATALOGUE, [folder])
    assert [kind.type for kind in catalogue] == [
        *(kind.type for kind in CATALOGUE),
        'low_pass',
    ]
    assert with_own_effects(catalogue, [folder]) == catalogue, 'named twice is once'


@pytest.fixture
def filtered(folder, robot, tmp_path):
    """A campaign, its elbow sensor behind a filter of 40 Hz; its file names the effect."""
    rng = np.random.default_rng(SEED)
    records = make_campaign(ROBOT, (), SEED, n_fit=2, n_held=1, duration=8.0, noise=0.0)
    for record in records:
        spectra = np.fft.rfft(record.acceleration[:, 6:9], axis=0)
        lag = 1.0 + 1j * np.fft.rfftfreq(len(record.acceleration), 1.0 / record.rate_hz) / 40.0
        record.acceleration[:, 6:9] = np.fft.irfft(
            spectra / lag[:, None], len(record.acceleration), axis=0
        )
        size = 0.05 * record.acceleration.std(axis=0)
        record.acceleration += size * rng.standard_normal(record.acceleration.shape)
    place = tmp_path / 'campaign'
    write_campaign(place, records, robot.joint_names, SENSORS)
    data = yaml.safe_load((place / 'campaign.yaml').read_text())
    (place / 'campaign.yaml').write_text(yaml.safe_dump({**data, 'effects': '../mine'}))
    return place


def test_programs_that_a_campaign_names_are_not_run_unasked(filtered, folder, robot):
    mark = folder / 'ran'
    (folder / 'low_pass.py').write_text(f'open({str(mark)!r}, "w")\n{CODE}')
    with pytest.raises(SettingsError, match='not run unasked') as caught:
        ama.gap(filtered, robot)
    assert str(folder.resolve()) in str(caught.value)
    assert not mark.exists()


@pytest.mark.slow
def test_it_is_screened_named_written_and_told(filtered, folder, robot, tmp_path):
    settings = SearchSettings(catalogue=(SensorDelay, SensorMountResonance), most_effects=1)
    found = ama.gap(filtered, robot, settings=settings, effects=[folder])
    assert found.verdict == 'named', f'seed {SEED}: {found}'
    (effect,) = found.effects
    assert (effect['type'], effect['location']) == ('low_pass', 'sensor:elbow')
    corner = effect['parameters']['corner']
    assert abs(corner['value'] - 40.0) < 4.0 * corner['sigma'], f'seed {SEED}: {corner}'
    assert 'Sensor elbow is behind a filter of ' in summary_lines(found.result)[0]
    found.save(tmp_path / 'out')
    text = json.loads((tmp_path / 'out' / 'gap.json').read_text())
    assert any(item['type'] == 'low_pass' for item in text['screened'])
    assert text['candidates'][0]['type'] == 'low_pass'
    assert 'is behind a filter of ' in (tmp_path / 'out' / 'report.html').read_text()
    (known,) = load_robot(tmp_path / 'out' / 'model_updated.yaml').spec.effects
    assert (known.type, known.kept_in) == ('low_pass', 'effects')


BROKEN = {
    'syntax': (CODE.replace('def apply(', 'def apply'), 'SyntaxError', 23),
    'import': ('import no_such_module\n' + CODE, 'ModuleNotFoundError', 1),
    'ends the program': ('import sys\nsys.exit(3)\n', 'SystemExit', 2),
    'no effect': ('x = 1\n', 'no effect', None),
    'unreadable': ('\x00', 'cannot be loaded', None),
    'no parameters': (CODE.replace('def parameters', 'def numbers'), 'parameters', None),
    'no source': (CODE.replace("source = '", "sauce = '"), 'source', None),
    'no name': (CODE.replace("'low_pass'", "'Low Pass'"), 'no name', None),
    'a name of ours': (CODE.replace("'low_pass'", "'payload'"), 'of one name', None),
    'words': (CODE.replace('{corner:.3g}', '{corner:.3q}'), 'says', None),
}


@pytest.mark.parametrize('kind', BROKEN)
def test_what_cannot_be_loaded_is_one_line_with_its_place(kind, tmp_path):
    text, said, line = BROKEN[kind]
    (tmp_path / 'bad.py').write_text(text)
    with pytest.raises(SettingsError) as caught:
        with_own_effects(CATALOGUE, [tmp_path])
    told = str(caught.value)
    assert '\n' not in told and said in told and str(tmp_path) in told
    assert line is None or f'bad.py:{line}' in told, told


FAILING = {
    'instances fail': ('return [cls(', 'return [1 / 0 + cls(', 'ZeroDivisionError'),
    'instances of what': ('return [cls(', 'return [str(', 'a list of effects'),
    'name in words': ('{corner:', '{cornr:', 'found {cornr}, expected place, corner'),
    'range': ('1.0, 2.0, 5000.0', '1.0, 5000.0, 2.0', 'impossible parameter'),
    'scale': ('1.0, 2.0', "float('nan'), 2.0", 'impossible parameter'),
    'starts': ('[(corner,)', '[(corner, 1.0)', '1 numbers in each start'),
    'starts below': ('(20.0, 50.0,', '(20.0, 0.5,', 'corner 0.5, expected 2 to 5000 Hz'),
    'starts of no logarithm': ('(20.0, 50.0,', '(20.0, -3.0,', 'corner -3, expected 2 to 5000'),
    'nothing starts': ('(20.0, 50.0, 120.0, 300.0)', '()', 'a list of starts'),
    'apply fails': ('own = [', 'own = values[7] + [', 'IndexError'),
    'apply ends the program': ('own = [', "__import__('sys').exit(3); own = [", 'SystemExit: 3'),
    'apply gives nothing': ('return cell.then_output', 'cell.then_output', 'a CellModel'),
    'apply gives no number': (
        'return cell.then_output(filtered)',
        "return __import__('dataclasses').replace(cell, tones=(float('nan'),))",
        'not a number',
    ),
    'filter': (
        'for row, mine in zip(readings, own)]',
        'for row, mine in zip([], own)]',
        'wrong shape',
    ),
    'filter gives no numbers': (
        'row * passed if',
        "row * float('nan') if",
        'NaN or infinite values from a filter (found 9 of 36 values, expected numbers)',
    ),
    'filter fails': ('passed = 1.0 /', 'passed = 1.0 + None /', 'TypeError'),
}


@pytest.mark.parametrize('kind', FAILING)
def test_what_fails_at_work_is_one_line_with_its_place(kind, robot, layout, tmp_path):
    old, new, said = FAILING[kind]
    assert old in CODE
    (tmp_path / 'bad.py').write_text(CODE.replace(old, new))
    scene = Scene(robot, tuple(it.name for it in layout), CellModel(robot.spec, layout.channels))
    (bad,) = with_own_effects((), [tmp_path])
    with pytest.raises(SettingsError) as caught:
        for effect in bad.instances(scene):
            effect.parameters(scene)
            for values in effect.starts(scene):
                cell = effect.apply(scene.cell, values, scene)
                cell.seen(np.ones(3), np.ones((12, 3), dtype=complex))
    told = str(caught.value)
    assert '\n' not in told and said in told and 'bad.py' in told, told


def test_the_line_is_told_of_a_folder_named_from_here(robot, layout, tmp_path, monkeypatch):
    broken = CODE.replace('return cell.then_output', 'return cel.then_output')
    (tmp_path / 'mine').mkdir()
    (tmp_path / 'mine' / 'bad.py').write_text(broken)
    (line,) = (at for at, text in enumerate(broken.splitlines(), 1) if 'return cel.' in text)
    monkeypatch.chdir(tmp_path)
    (bad,) = with_own_effects((), [Path('mine')])
    scene = Scene(robot, tuple(it.name for it in layout), CellModel(robot.spec, layout.channels))
    with pytest.raises(SettingsError) as caught:
        bad.instances(scene)[0].apply(scene.cell, (50.0,), scene)
    assert str(caught.value).startswith(f'mine/bad.py:{line}: class LowPass: apply(): ')


def test_a_folder_that_is_none_is_one_line(tmp_path):
    for path in (tmp_path, tmp_path / 'nowhere'):
        with pytest.raises(SettingsError, match=str(path)):
            with_own_effects(CATALOGUE, [path])


def test_a_corrected_model_with_an_effect_of_ones_own_says_what_it_needs(robot, layout, folder):
    known = KnownEffect('low_pass', 'sensor:elbow', '', 'effects', (KnownNumber('corner', 40.0),))
    spec = dataclasses.replace(robot.spec, effects=(known,))
    scene = Scene(robot, (), CellModel(spec, layout.channels))
    with pytest.raises(ModelError, match='name its folder') as caught:
        with_known_effects(scene)
    assert 'tuned_mass' not in str(caught.value), 'no list of what it is not'
    cell = with_known_effects(scene, with_own_effects(CATALOGUE, [folder]))
    assert len(cell.outputs) == 1
