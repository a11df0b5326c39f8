"""Modes that other programs wrote into universal files, read and compared."""

import json

import numpy as np
import pytest
import pyuff

from autonomous_modal_analysis.export import export_modes, Exported
from modal_core.errors import RecordingError
from modal_core.mode import Mode, ModeSet
from modal_recordings.universal.universal_shapes import read_shapes


def some_modes(seed=4):
    rng = np.random.default_rng(seed)
    names = ('3:+X', '3:-Z', '7:+Y')
    modes = []
    for hz in (31.5, 12.25):
        shape = rng.normal(size=3) + 0.1j * rng.normal(size=3)
        shape = shape / shape[np.abs(shape).argmax()]
        modes.append(Mode(hz, 0.012, shape, frequency_std_hz=0.02))
    return ModeSet(tuple(modes), names)


def test_our_own_modes_come_back(tmp_path):
    """Six digits, as the format has them; what was left out stays out, σ is not in it."""
    modes = some_modes()
    export_modes(tmp_path / 'm.uff', Exported(modes, ModeSet((), modes.channel_names), {}))
    found = read_shapes(tmp_path / 'm.uff')
    assert found.channel_names == ('3:+X', '3:+Z', '7:+Y')
    np.testing.assert_allclose(found.frequency_hz, [12.25, 31.5], rtol=1e-5)
    np.testing.assert_allclose(found.damping_ratio, 0.012, rtol=1e-3)
    for mode, true in zip(found, reversed(modes.modes), strict=True):
        shape = true.shape * np.array([1.0, -1.0, 1.0])
        np.testing.assert_allclose(mode.shape / mode.shape[0], shape / shape[0], rtol=1e-4)
        assert np.isnan(mode.frequency_std_hz)


def test_rotations_are_no_displacements_of_nodes(tmp_path):
    modes = some_modes()
    named = ModeSet(modes.modes, ('low.x', 'low.gyro_x', 'high.x'))
    none = ModeSet((), named.channel_names)
    exported = Exported(named, none, {}, others=frozenset({'low.gyro_x'}))
    export_modes(tmp_path / 'm.uff', exported)
    found = read_shapes(tmp_path / 'm.uff')
    assert found.channel_names == ('1:+X', '2:+X')
    for mode, true in zip(found, reversed(modes.modes), strict=True):
        ratio = true.shape[2] / true.shape[0]
        np.testing.assert_allclose(mode.shape[1] / mode.shape[0], ratio, rtol=1e-4)


def test_normal_modes_of_another_program_are_read(tmp_path):
    """Real shapes with frequency and viscous damping, as finite elements write them."""
    content = {
        'type': 55, 'analysis_type': 2, 'data_ch': 2, 'spec_data_type': 8, 'data_type': 2,
        'n_data_per_node': 3, 'id1': 'a', 'load_case': 0, 'mode_n': 1, 'freq': 9.5,
        'modal_m': 1.0, 'modal_damp_vis': 0.02, 'modal_damp_his': 0.0,
        'node_nums': np.array([1, 2]), 'r1': np.array([0.5, 1.0]), 'r2': np.zeros(2),
        'r3': np.array([0.0, -0.25]),
    }  # fmt: skip
    pyuff.UFF(str(tmp_path / 'fe.unv')).write_sets([content], 'add')
    found = read_shapes(tmp_path / 'fe.unv')
    assert found.channel_names == ('1:+X', '2:+X', '2:+Z')
    (mode,) = found
    assert mode.frequency_hz == pytest.approx(9.5) and mode.damping_ratio == pytest.approx(0.02)
    np.testing.assert_allclose(mode.shape, [0.5, 1.0, -0.25], atol=1e-6)
    assert mode.mpc == pytest.approx(1.0)


@pytest.mark.parametrize('cut', [0.3, 0.6, 0.9])
def test_a_truncated_file_is_refused(tmp_path, cut):
    modes = some_modes()
    export_modes(tmp_path / 'm.uff', Exported(modes, ModeSet((), modes.channel_names), {}))
    text = (tmp_path / 'm.uff').read_bytes()
    (tmp_path / 'm.uff').write_bytes(text[: int(cut * len(text))])
    with pytest.raises(RecordingError) as error:
        read_shapes(tmp_path / 'm.uff')
    assert 'm.uff' in str(error.value) and '\n' not in str(error.value)


def test_compare_takes_a_universal_file(ama, tmp_path):
    """Two files of modes, the second one per cent lower."""
    modes = some_modes()
    lower = [
        Mode(0.99 * mode.frequency_hz, mode.damping_ratio, mode.shape) for mode in modes.modes
    ]
    for name, some in (('a', modes), ('b', ModeSet(tuple(lower), modes.channel_names))):
        export_modes(tmp_path / f'{name}.uff', Exported(some, ModeSet((), some.channel_names), {}))
    run = ama('compare', tmp_path / 'a.uff', tmp_path / 'b.uff', '--json', '--out', tmp_path)
    assert run.returncode == 0, run.stderr
    told = json.dumps(json.loads(run.stdout))
    assert '12.25' in told and (tmp_path / 'comparison.html').is_file()
