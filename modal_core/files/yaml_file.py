"""Read YAML that may come from anywhere: bounded in size, depth and cost, one clear error."""

from collections.abc import Hashable, Iterator
from pathlib import Path
from typing import Any, TYPE_CHECKING

import yaml

from modal_core.errors import SettingsError
from modal_core.files.small_file import read_text

LARGEST_FILE_BYTES = 500_000
DEEPEST = 32
"""Collections inside one another; our own files have six.  The scanner looks at every open one
for each word: its time is depth times length."""
LIBRARY_TOO_DEEP = 'exceeded maximum nesting depth'
"""libyaml from 0.2.6 on says so of a line it has scanned before it gives the events."""
# libyaml's is ten times as fast; where PyYAML was built without it, the other reads the same.
if TYPE_CHECKING:
    _Safe = yaml.SafeLoader
else:
    _Safe = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)


TWICE, TOO_LARGE = 'key given twice', 'number too large'


class _Loader(_Safe):
    """A safe loader, which refuses a key that is given twice and what no float holds."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        seen: set[str] = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode) and key.value in seen:
                raise yaml.constructor.ConstructorError(None, None, TWICE, key.start_mark)
            seen.add(str(key.value) if isinstance(key, yaml.ScalarNode) else '')
        found: dict[Hashable, Any] = super().construct_mapping(node, deep)
        return found

    def construct_whole(self, node: yaml.ScalarNode) -> int:
        number: int = self.construct_yaml_int(node)
        try:
            float(number)
        except OverflowError as error:
            raise yaml.constructor.ConstructorError(
                None, None, TOO_LARGE, node.start_mark
            ) from error
        return number


_Loader.add_constructor('tag:yaml.org,2002:int', _Loader.construct_whole)


def load_yaml(path: Path) -> dict[str, object]:
    """Return the mapping a YAML file holds.

    Raises
    ------
    SettingsError
        The file is missing, too large, not YAML, nested too deeply, uses aliases, or is not a
        mapping.
    """
    data = parse_yaml(read_text(path, LARGEST_FILE_BYTES), path)
    if not isinstance(data, dict):
        raise SettingsError('not a mapping', where=path, found=type(data).__name__)
    return data


def parse_yaml(text: str, where: object, largest: int = LARGEST_FILE_BYTES) -> object:
    """Return what YAML text holds.

    Parameters
    ----------
    text : str
        The text.
    where : object
        What to call it in errors; none of it is repeated there.
    largest : int
        Characters it may have.

    Raises
    ------
    SettingsError
        It is too long, not YAML, nested too deeply, uses aliases, or holds a whole number beyond
        floating-point numbers.
    """
    if len(text) > largest:
        raise SettingsError('too long', where=where, expected=f'<= {largest} letters')
    try:
        for _ in _bounded(text, where):
            pass
        return yaml.load(text, Loader=_Loader)  # noqa: S506  a safe loader
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        place = f', line {mark.line + 1}, column {mark.column + 1}' if mark else ''
        if error.problem == LIBRARY_TOO_DEEP:
            raise _too_deep(f'{where}{place}') from error
        what = error.problem if error.problem in (TWICE, TOO_LARGE) else 'not YAML'
        raise SettingsError(what, where=f'{where}{place}') from error
    except (yaml.YAMLError, ValueError, RecursionError, OverflowError) as error:
        raise SettingsError('not YAML', where=where) from error


def _bounded(text: str, where: object) -> Iterator[yaml.Event]:
    """Yield the events of the text, refusing what makes a few lines into hours or gigabytes."""
    depth = 0
    for event in yaml.parse(text, Loader=_Safe):
        # No file of ours needs aliases.
        if isinstance(event, yaml.AliasEvent):
            raise SettingsError('YAML aliases are not accepted', where=where)
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            raise _too_deep(where)
        yield event


def _too_deep(where: object) -> SettingsError:
    return SettingsError('nested too deeply', where=where, expected=f'at most {DEEPEST} levels')
