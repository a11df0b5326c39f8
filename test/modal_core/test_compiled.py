"""Compiled functions are compiled anew when what they do has changed."""

import importlib
from pathlib import Path

import pytest

numba = pytest.importorskip('numba')
ROOT = Path(__file__).resolve().parents[2]
FILES = [
    path
    for room in sorted(ROOT.glob('*/__init__.py'))
    for path in sorted(room.parent.rglob('*.py'))
    if '\n@compiled\n' in path.read_text()
]


def is_compiled(item):
    return isinstance(item, numba.core.dispatcher.Dispatcher)


def test_there_are_some():
    assert any(path.parent.name == 'laws' for path in FILES)


@pytest.mark.parametrize('path', FILES, ids=lambda path: path.stem)
def test_compiled_functions_call_those_of_their_own_file_alone(path):
    """What is kept of a caller holds the callee too, and looks at the caller's file only."""
    name = '.'.join(path.relative_to(ROOT).with_suffix('').parts)
    found = [item for item in vars(importlib.import_module(name)).values() if is_compiled(item)]
    assert found
    for item in found:
        function = item.py_func
        assert function.__closure__ is None, 'kept under another name in every run'
        called = [function.__globals__.get(name) for name in function.__code__.co_names]
        for other in filter(is_compiled, called):
            assert other.py_func.__module__ == function.__module__
