"""Every flag that code sets has words."""

import ast
from collections.abc import Iterator
import importlib
from pathlib import Path
import re
from types import ModuleType

from modal_core.words.flag_words import FLAG_WORDS
import oma_identifier
from oma_identifier.quality import EXCLUDING

FLAG = re.compile(r'[a-z]+(_[a-z]+)*')


def flags_set_in(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding='utf-8'))
    values = list(values_of_flags(tree))
    if not values:
        return set()
    parts = path.relative_to(Path(oma_identifier.__file__).parents[1]).with_suffix('').parts
    module = importlib.import_module('.'.join(parts))
    return {text for value in values for text in strings(module, value) if FLAG.fullmatch(text)}


def values_of_flags(tree: ast.AST) -> Iterator[ast.expr]:
    """Yield what is given to anything called flags, and what functions of flags return."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            if re.search(r'(flags|found)\.(add|append)$|_break$', ast.unparse(node.func)):
                yield from node.args
            yield from (word.value for word in node.keywords if (word.arg or '').endswith('flags'))
        elif isinstance(node, ast.Assign | ast.AugAssign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if node.value and any('flags' in ast.unparse(target) for target in targets):
                yield node.value
        elif isinstance(node, ast.FunctionDef) and 'flags' in node.name:
            returned = (ast.Return, ast.Yield)
            yield from (n.value for n in ast.walk(node) if isinstance(n, returned) and n.value)


def strings(module: ModuleType, value: ast.expr) -> Iterator[str]:
    for node in ast.walk(value):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value
        elif isinstance(node, ast.Name) and isinstance(getattr(module, node.id, None), str):
            yield getattr(module, node.id)


def test_every_flag_that_is_set_has_words():
    from oma_identifier.motion import sensor_check
    from oma_identifier.synchrony.change_kind import CHANGES

    found = {*EXCLUDING, *CHANGES, sensor_check.GAIN, sensor_check.POLARITY, sensor_check.AXES}
    found |= {'small_suspicion', 'large_suspicion', 'partial', 'restarted', 'wrapped'}
    found |= {'rectified', 'rows_reversed'}
    for path in Path(oma_identifier.__file__).parent.rglob('*.py'):
        if not path.name.endswith(('_node.py', 'ros_messages.py')):
            found |= flags_set_in(path)
    assert {'degraded', 'impulsive', 'clock_jump', 'incoherent', 'modes_vary'} <= found
    without = found - set(FLAG_WORDS)
    assert not without, sorted(without)
