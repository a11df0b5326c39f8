"""A mode is written once: what is written is read back, whatever its fields are."""

import dataclasses
import json

import numpy as np
import pytest

from autonomous_modal_analysis.identified.results import (
    Identification,
    identification_json,
    json_text,
    write_json,
)
from autonomous_modal_analysis.read_results import read_modes
from excitation_planner.ros_messages import modes_from_message
from modal_core.errors import RecordingError
from modal_core.mode import Mode, MODE_FIELDS, MODE_KEYS, ModeSet
from modal_core.settings.quantity import quantities_of, quantity
from oma_identifier.node.ros_messages import mode_message
from oma_msgs.msg import ModalParameters

SEED = 20


def drawn(random, n_channels):
    """Return a mode with every field known, and one with nothing known that may be unknown."""
    known, least = {}, {}
    for item in MODE_FIELDS:
        low, high = max(item.low, -5.0), min(item.high, 3.0)
        if item.kind is complex:
            value = random.uniform(max(low, 0.0), 1.0, (2, n_channels))
            known[item.name] = value[0] + 1j * value[1]
        elif item.kind is not bool:
            known[item.name] = item.kind(random.uniform(low, high))
    for name in ('frequency_hz', 'damping_ratio', 'shape'):
        least[name] = known[name]
    return Mode(**known), Mode(**least)


def same(first, second):
    for item in MODE_FIELDS:
        a, b = getattr(first, item.name), getattr(second, item.name)
        assert (a is None) == (b is None), item.name
        if a is not None:
            np.testing.assert_array_equal(a, b, err_msg=item.name)


def test_files_and_messages_give_back_every_field(tmp_path):
    random = np.random.default_rng(SEED)
    modes = tuple(mode for _ in range(10) for mode in drawn(random, 3))
    modes = tuple(sorted(modes, key=lambda mode: mode.frequency_hz))
    names = ('a', 'b', 'c')
    path = tmp_path / 'modes.json'
    path.write_text(json_text(identification_json(Identification(ModeSet(modes, names)))))
    message = ModalParameters(
        channel_names=list(names), modes=[mode_message(mode) for mode in modes]
    )
    for back in (read_modes(path), modes_from_message(message)):
        assert len(back) == len(modes), f'seed {SEED}'
        for wanted, found in zip(modes, back, strict=True):
            same(wanted, found)


def test_a_file_says_where_it_comes_from_and_one_of_a_later_format_is_refused(tmp_path):
    path = tmp_path / 'modes.json'
    write_json(path, Identification(ModeSet((), ('a',))), 'arm.mcap')
    found = json.loads(path.read_text())
    assert found['file']['recording'] == 'arm.mcap'
    assert found['file']['software'].startswith('autonomous_modal_analysis')
    assert not len(read_modes(path))
    found['file']['format_version'] = 2
    path.write_text(json.dumps(found))
    with pytest.raises(RecordingError, match='format version 2'):
        read_modes(path)


def test_files_of_before_a_field_was_there_are_read():
    mode, _ = drawn(np.random.default_rng(SEED), 2)
    values = json.loads(json_text({k: v for k, v in mode.values().items() if 'mac_loss' not in k}))
    assert np.isnan(Mode.from_values(values, 2).mac_loss)


@pytest.mark.parametrize('item', [item for item in MODE_FIELDS if np.isfinite(item.low)])
def test_every_range_is_held(item):
    mode, _ = drawn(np.random.default_rng(SEED), 2)
    beyond = item.low - 1.0
    values = mode.values() | item.write(beyond * np.ones(2) if item.kind is complex else beyond)
    with pytest.raises(ValueError, match=item.name):
        Mode.from_values(values, 2)


def test_a_new_field_stands_once():
    @dataclasses.dataclass(frozen=True)
    class More(Mode):
        """A mode with one field more."""

        modal_mass_kg: float = quantity('modal mass', 'kg', 0.0, default=float('nan'))

    item = tuple(quantities_of(More))[-1]
    assert (item.keys, item.column, item.single) == (('modal_mass_kg',), 'modal_mass_kg', True)
    assert item.read(item.write(3.0), 2) == 3.0
    assert np.isnan(item.read({}, 2))


def test_columns_tell_their_unit():
    columns = {item.name: item.column for item in MODE_FIELDS}
    assert columns['mpd'] == 'mpd_rad'
    assert columns['frequency_std_hz'] == 'frequency_std_hz'
    assert set(MODE_KEYS) >= {'shape_real', 'shape_std_imag', 'mac_loss'}
