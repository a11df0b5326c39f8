"""Settings are written once: node, command line and documents show the same."""

from dataclasses import dataclass, fields
import inspect

import pytest

from autonomous_modal_analysis.api.settings import Settings
from autonomous_modal_analysis.commands.identify import identify
from autonomous_modal_analysis.console.option_groups import grouped, Identifier
from modal_core.errors import SettingsError
from modal_core.settings.schema import from_parameters, parameter_values, setting, settings_of
from oma_identifier.node.node_parameters import SETTINGS, settings_from
from oma_identifier.settings import IdentificationSettings


def _options(command):
    return inspect.signature(command).parameters


def test_node_command_line_and_keywords_have_the_same_settings():
    names = [item.name for item in fields(IdentificationSettings)]
    assert [item.name for item in settings_of(IdentificationSettings)] == names
    assert [parameter.name for parameter in SETTINGS] == names
    assert list(Settings.__annotations__) == names
    assert set(names) <= set(_options(grouped(identify)))


def test_defaults_are_the_same_everywhere():
    options = _options(grouped(identify))
    for item in fields(IdentificationSettings):
        assert options[item.name].default == item.default
    defaults = {parameter.name: parameter.default for parameter in SETTINGS}
    assert settings_from(defaults) == IdentificationSettings()
    assert Identifier().settings == IdentificationSettings()


@pytest.mark.parametrize(
    'settings',
    [
        IdentificationSettings(refine=True),
        IdentificationSettings(refine=False, hop_s=3.0, block_rows=20, n_references=2),
        IdentificationSettings(window_s=7.0, min_order=4, max_order=8, max_damping_ratio=0.3),
    ],
)
def test_settings_go_through_a_node_unchanged(settings):
    assert settings_from(parameter_values(settings)) == settings


@dataclass(frozen=True)
class Two:
    """Settings with one default that is none of the identifier's."""

    length_s: float = setting(7.0, 'length [s]', 1.0, 9.0)
    rows: int | None = setting(None, 'rows', 2, 5, automatic='from the data')


def test_a_new_setting_has_its_range_type_and_automatic_value():
    length, rows = settings_of(Two)
    assert (length.kind, length.default, rows.kind) == (float, 7.0, int)
    assert parameter_values(Two()) == {'length_s': 7.0, 'rows': 0}
    assert from_parameters(Two, {'length_s': 2.0, 'rows': 0}) == {'length_s': 2.0, 'rows': None}
    with pytest.raises(SettingsError, match='length_s'):
        length.check(10.0)


def test_a_switch_of_the_node_refuses_other_words():
    values = {**parameter_values(IdentificationSettings()), 'refine': 'perhaps'}
    with pytest.raises(SettingsError, match='auto, always, never'):
        settings_from(values)
