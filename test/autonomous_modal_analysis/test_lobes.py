"""`ama lobes`: a tool and a cut in files, limits and proposals out."""

import csv
import json
import math
import subprocess
import sys

import numpy as np
import pytest

import autonomous_modal_analysis as ama
from machining.task import read_tool_modes
from modal_core.tool_modes import ToolModes

WECK = """modes:
- {frequency_hz: 603, frequency_std_hz: 3, damping_ratio: 0.039, damping_ratio_std: 0.002,
   stiffness_n_m: 5.59e6, direction: [1, 0, 0]}
- {frequency_hz: 666, frequency_std_hz: 3, damping_ratio: 0.035, damping_ratio_std: 0.002,
   modal_mass_kg: 0.32637, modal_mass_std_kg: 0.01, direction: [0, 2, 0]}
"""
CUT = """n_teeth: 3
diameter_mm: 20
tangential_n_mm2: 600
radial_n_mm2: 42
way: up
radial_depth_mm: 10
min_speed_rpm: 4000
max_speed_rpm: 16000
n_speeds: 7
n_samples: 5
feed_deg: [0.0]
"""


def run(*arguments):
    command = [sys.executable, '-m', 'autonomous_modal_analysis', *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture
def files(tmp_path):
    tool, cut = tmp_path / 'tool.yaml', tmp_path / 'cut.yaml'
    tool.write_text(WECK)
    cut.write_text(CUT)
    return tool, cut


@pytest.mark.slow
def test_limits_of_the_textbook_machine_in_all_files(files, tmp_path):
    tool, cut = files
    said = run('lobes', tool, '--cut', cut, '--out', tmp_path / 'out', '--json')
    assert said.returncode == 0, said.stderr
    found = json.loads(said.stdout)
    (chart,) = found['charts']
    at = chart['speed_rpm'].index(8000.0)
    # ZOA 1.095 mm and 627 Hz, semi-discretisation 1.099 mm of the published example.
    assert chart['mean_limit_m'][at] == pytest.approx(1.095e-3, rel=0.01)
    assert chart['limit_m'][at] == pytest.approx(1.099e-3, rel=0.01)
    assert chart['chatter_hz'][at] == pytest.approx(627.0, abs=1.0)
    assert chart['safe_depth_m'][at] < chart['limit_m'][at]
    assert 0.0 <= found['proposals'][0]['chance'] <= 0.05
    with (tmp_path / 'out' / 'lobes.csv').open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[at]['limit_m']) == chart['limit_m'][at]
    page = (tmp_path / 'out' / 'report.html').read_text()
    assert '<polygon' in page and 'http://' not in page.replace('http://www.w3.org', '')
    kept = json.loads((tmp_path / 'out' / 'lobes.json').read_text())
    assert kept['charts'] == found['charts']


def test_a_table_of_responses_is_as_good_as_its_modes(files, tmp_path):
    _, cut = files
    mass = np.array([5.59e6, 5.715e6]) / (2 * np.pi * np.array([603.0, 666.0])) ** 2
    shape = np.eye(2, 3) / np.sqrt(mass)[:, None]
    modes = ToolModes(np.array([603.0, 666.0]), np.array([0.039, 0.035]), shape)
    lines = np.arange(100.0, 1400.0, 1.0)
    accelerance = -((2 * np.pi * lines) ** 2)[:, None, None] * modes.receptance(lines)
    columns = [lines]
    for i, j in ((0, 0), (1, 1)):
        columns += [accelerance[:, i, j].real, accelerance[:, i, j].imag]
    table = tmp_path / 'frf.csv'
    head = 'frequency_hz,xx_real,xx_imag,yy_real,yy_imag'
    np.savetxt(table, np.column_stack(columns), delimiter=',', header=head, comments='')
    found = ama.lobes(table, cut, response='accelerance', theory='mean').found
    direct = ama.lobes(modes, cut, theory='mean').found
    assert found.charts[0].mean.depth_m == pytest.approx(direct.charts[0].mean.depth_m, rel=5e-3)


@pytest.mark.slow
def test_modes_of_a_tap_test_need_the_channels_of_the_tool(tmp_path, files):
    _, cut = files
    mode = {
        'frequency_hz': 603.0, 'frequency_std_hz': 1.0, 'damping_ratio': 0.03,
        'damping_ratio_std': 0.001, 'shape_real': [1.0, 0.2], 'shape_imag': [0.0, 0.0],
        'modal_mass_kg': 0.39, 'modal_mass_std_kg': 0.01,
    }  # fmt: skip
    file = tmp_path / 'modes.json'
    file.write_text(json.dumps({'shape_channels': ['tip.x', 'tip.y'], 'modes': [mode]}))
    found = ama.lobes(file, cut, tool_channels=['tip.x', 'tip.y', '-'], theory='mean').found
    assert math.isfinite(found.charts[0].mean.depth_m.min())
    refused = run('lobes', file, '--cut', cut)
    assert refused.returncode == 2
    assert '--tool-channels' in refused.stderr and refused.stderr.count('\n') == 1
    del mode['modal_mass_kg']
    file.write_text(json.dumps({'shape_channels': ['tip.x', 'tip.y'], 'modes': [mode]}))
    refused = run('lobes', file, '--cut', cut, '--tool-channels', 'tip.x,tip.y,-')
    assert refused.returncode == 2 and 'without modal mass' in refused.stderr


@pytest.mark.parametrize('size', ['1.0e-320', '1.0e+308'])
def test_a_direction_has_no_size(tmp_path, size):
    mode = '- {{frequency_hz: 603, damping_ratio: 0.03, modal_mass_kg: 1, direction: [{}, {}, 0]}}'
    shapes = []
    for each in ('1.0', size):
        file = tmp_path / 'tool.yaml'
        file.write_text('modes:\n' + mode.format(each, each))
        shapes.append(read_tool_modes(file).shape)
    assert np.isfinite(shapes[1]).all() and np.allclose(*shapes)


ROW = '- {frequency_hz: 603, damping_ratio: 0.03, shape: [1, 0, 0]'


@pytest.mark.parametrize(
    ('tool', 'cut', 'said'),
    [
        ('modes: []', CUT, 'no number of modes'),
        ('frequency_hz: 603', CUT, 'no list of modes'),
        ('modes:\n- {frequency_hz: 603, damping_ratio: 0.03}', CUT, 'no scale'),
        (f'modes:\n{ROW}, modal_mass_kg: 1}}', CUT, 'more than one'),
        ('modes:\n- {frequency_hz: -1, damping_ratio: 0.03, shape: [1,0,0]}', CUT, 'out of range'),
        ('modes:\n- {frequency_hz: 9, damping_ratio: .nan, shape: [1,0,0]}', CUT, 'out of range'),
        ('modes:\n- {frequency_hz: 9, damping_ratio: 0.1, shape: [0,0,0]}', CUT, 'no vector'),
        (f'modes:\n{ROW}, colour: red}}', CUT, 'colour'),
        (f'modes:\n{ROW}}}\ncovariance: [[1]]', CUT, 'covariance'),
        (f'modes:\n{ROW}, frequency_std_hz: 1}}\n{ROW}}}', CUT, 'some modes only'),
        (WECK, CUT.replace('n_teeth: 3', 'n_teeth: 0'), 'n_teeth'),
        (WECK, CUT.replace('n_teeth: 3', 'teeth: 3'), 'teeth'),
        (WECK, CUT.replace('way: up', 'way: sideways'), 'sideways'),
        (WECK, CUT.replace('radial_depth_mm: 10', 'radial_depth_mm: 30'), 'deeper'),
        (WECK, CUT.replace('diameter_mm: 20\n', ''), 'diameter_mm'),
        (WECK, CUT.replace('max_speed_rpm: 16000', 'max_speed_rpm: 100'), 'no range'),
        (WECK, CUT + 'feed_axis: [0.0, 0.0, 1.0]\n', 'feed along the spindle'),
    ],
)
def test_bad_input_is_one_line(tmp_path, tool, cut, said):
    (tmp_path / 'tool.yaml').write_text(tool)
    (tmp_path / 'cut.yaml').write_text(cut)
    with pytest.raises(ama.ModalAnalysisError) as caught:
        ama.lobes(tmp_path / 'tool.yaml', tmp_path / 'cut.yaml')
    assert said in str(caught.value) and '\n' not in str(caught.value)


@pytest.mark.parametrize(
    'text',
    [
        'frequency_hz,xx_real\n' + '1,2\n' * 9,
        'frequency_hz,xx_real,xx_imag\n1,2,3\n',
        'f,xx_real,xx_imag\n' + '1,2,3\n' * 9,
        'frequency_hz,xx_real,xx_imag\n' + '1,2,3\n' * 9,
        'frequency_hz,xx_real,xx_imag\n' + ''.join(f'{i + 1},2,nan\n' for i in range(9)),
        'frequency_hz,xx_real,xx_imag\n' + ''.join(f'{i + 1},2\n' for i in range(9)),
    ],
)
def test_no_table_of_a_response_is_one_line(tmp_path, text):
    (tmp_path / 'frf.csv').write_text(text)
    (tmp_path / 'cut.yaml').write_text(CUT)
    with pytest.raises(ama.ModalAnalysisError) as caught:
        ama.lobes(tmp_path / 'frf.csv', tmp_path / 'cut.yaml')
    assert '\n' not in str(caught.value)
