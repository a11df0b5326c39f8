"""The package loads nothing before it is used, and needs no ROS."""

import doctest
from importlib import import_module
import inspect
from pathlib import Path
import subprocess
import sys
from typing import get_args, get_type_hints

import pytest

import autonomous_modal_analysis as ama
from autonomous_modal_analysis.api.settings import Settings
from modal_core.files.version import suite_version
from oma_identifier.settings import IdentificationSettings

API = Path(ama.__file__).parent / 'api'
MODULES = [
    'autonomous_modal_analysis',
    *(f'autonomous_modal_analysis.api.{path.stem}' for path in sorted(API.glob('[!_]*.py'))),
]


def run(code: str) -> str:
    finished = subprocess.run(
        [sys.executable, '-c', code], capture_output=True, text=True, timeout=60, check=False
    )
    assert finished.returncode == 0, finished.stderr
    return finished.stdout


def test_importing_the_package_loads_no_library():
    said = run(
        'import sys, autonomous_modal_analysis as ama\n'
        "heavy = {'numpy', 'scipy', 'rich', 'typer', 'pinocchio', 'matplotlib', 'pandas'}\n"
        "rooms = {'modal_core', 'modal_recordings', 'oma_identifier', 'structural_model'}\n"
        'print(sorted((heavy | rooms) & set(sys.modules)))\n'
        'print(set(ama.__all__) <= set(dir(ama)))'
    )
    assert said.split('\n')[:2] == ['[]', 'True']


def test_nothing_of_it_needs_ros_or_what_is_optional():
    said = run(
        'import sys\n'
        "for name in ('rclpy', 'oma_msgs', 'sensor_msgs', 'std_msgs', 'pandas', 'matplotlib'):\n"
        '    sys.modules[name] = None\n'
        'import autonomous_modal_analysis as ama\n'
        'for name in ama.__all__:\n'
        '    getattr(ama, name)\n'
        "arm = ama.model('generic_arm_6')\n"
        'print(len(arm.frequencies_hz) > 0)'
    )
    assert said.strip() == 'True'


def test_identifying_loads_no_robot():
    said = run(
        'import sys, autonomous_modal_analysis as ama\n'
        'ama.identify, ama.open\n'
        "print('pinocchio' in sys.modules, 'matplotlib' in sys.modules)"
    )
    assert said.split() == ['False', 'False']


def test_public_names_are_what_they_say():
    assert ama.__version__ == suite_version()
    assert sorted(ama.__all__) == ama.__all__
    for name in ama.__all__:
        assert inspect.getdoc(getattr(ama, name)), name
    with pytest.raises(AttributeError, match='has no attribute'):
        _ = ama.identity


def test_settings_as_keywords_are_the_settings():
    keywords, fields = get_type_hints(Settings), get_type_hints(IdentificationSettings)
    assert {name: set(get_args(kind) or [kind]) for name, kind in keywords.items()} == {
        name: set(get_args(kind) or [kind]) for name, kind in fields.items()
    }


@pytest.mark.parametrize('name', MODULES)
def test_examples_give_what_they_show(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    failed, _ = doctest.testmod(import_module(name))
    assert failed == 0


def test_the_main_functions_have_examples():
    for name in ('identify', 'open', 'plan', 'model'):
        assert '>>> ' in inspect.getdoc(getattr(ama, name)), name
