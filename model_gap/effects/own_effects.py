"""Effects of one's own: from files in a folder, or installed as an entry point.

They are classes like those of the catalogue.  What goes wrong in one is told in one line: what,
and in which line of whose file.
"""

from collections.abc import Callable, Iterable, Sequence
from hashlib import sha256
from importlib.metadata import entry_points
from importlib.util import module_from_spec, spec_from_file_location
import inspect
from pathlib import Path
import re
import sys
from types import ModuleType

from modal_core.errors import ModalAnalysisError, SettingsError
from model_gap.effects.code_place import CodePlace
from model_gap.effects.effect import Effect
from model_gap.effects.guard import guarded

GROUP = 'autonomous_modal_analysis.effects'
TYPE_NAME = re.compile(r'[a-z][a-z0-9_]*')
WORDS = ('equation', 'source', 'signature')


def with_own_effects(
    catalogue: Sequence[type[Effect]], folders: Iterable[Path] = ()
) -> tuple[type[Effect], ...]:
    """Return a catalogue with installed effects and those of some folders after its own.

    Parameters
    ----------
    catalogue : sequence of Effect types
        To begin with.
    folders : iterable of Path
        Folders of Python files with effects, or single files.

    Raises
    ------
    SettingsError
        An effect cannot be loaded, lacks something, or has the name of another one.
    """
    found = list(catalogue)
    own = [*installed_effects(), *(kind for path in folders for kind in effects_in(Path(path)))]
    for kind in own:
        if kind in found:
            continue
        if any(kind.type == other.type for other in found):
            raise SettingsError(
                'two effects of one name',
                where=inspect.getfile(kind),
                found=kind.type,
                advice='give yours another type',
            )
        found.append(kind)
    return tuple(found)


def installed_effects() -> list[type[Effect]]:
    """Return the effects that installed packages declare as entry points."""
    found = []
    for entry in sorted(entry_points(group=GROUP), key=lambda item: item.name):
        where = CodePlace(f'entry point {entry.name} = {entry.value}')
        kind = _told(entry.load, where, 'uninstall the package, or mend it')
        if not (inspect.isclass(kind) and issubclass(kind, Effect)):
            raise SettingsError('not an effect', where=where, found=kind, expected='its class')
        found.append(_checked(kind, where))
    return found


def effects_in(path: Path) -> list[type[Effect]]:
    """Return the effects of a folder's Python files, or of one file."""
    if path.is_dir():
        files = sorted(file for file in path.glob('*.py') if not file.name.startswith('_'))
    else:
        files = [path]
    found = [kind for file in files for kind in _effects_of(file)]
    if not found:
        raise SettingsError(
            'no effect', where=path, expected='Python files with subclasses of Effect'
        )
    return found


def _effects_of(file: Path) -> list[type[Effect]]:
    module = _module(file)
    kinds = [
        kind
        for kind in vars(module).values()
        if inspect.isclass(kind)
        and issubclass(kind, Effect)
        and kind.__module__ == module.__name__
    ]
    # What others of the file are derived from need not be an effect itself.
    bases = {base for kind in kinds for base in kind.__mro__[1:]}
    return [
        _checked(kind, CodePlace(str(file)))
        for kind in dict.fromkeys(kinds)
        if not (inspect.isabstract(kind) and kind in bases)
    ]


def _module(file: Path) -> ModuleType:
    """Return the module of a file; the same one again as long as the file is as it was."""
    try:
        text = file.read_bytes()
    except OSError as error:
        raise SettingsError('cannot be read', where=file, found=error.strerror) from error
    digest = sha256(str(file.resolve()).encode() + text).hexdigest()[:16]
    name = f'own_effects_{re.sub(r"[^0-9A-Za-z]", "_", file.stem)}_{digest}'
    if name in sys.modules:
        return sys.modules[name]
    spec = spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise SettingsError('not a Python file', where=file)
    module = module_from_spec(spec)
    sys.modules[name] = module  # pickled classes are looked up there
    try:
        _told(lambda: spec.loader.exec_module(module), CodePlace(str(file)))  # type: ignore[union-attr]
    except ModalAnalysisError:
        del sys.modules[name]
        raise
    return module


def _told(load: Callable[[], object], where: CodePlace, advice: str = '') -> object:
    try:
        return load()
    except ModalAnalysisError:
        raise
    except (Exception, SystemExit) as error:
        raise SettingsError(
            f'cannot be loaded: {type(error).__name__}: {error}',
            where=where.of(error),
            advice=advice,
        ) from error


def _checked(kind: type[Effect], where: CodePlace) -> type[Effect]:
    """Return an effect that says what it must, its methods guarded."""
    where = where.inside(f'class {kind.__name__}')
    missing = sorted(kind.__abstractmethods__) if inspect.isabstract(kind) else []
    missing += [
        name
        for name in ('type', *WORDS)
        if not (isinstance(getattr(kind, name, None), str) and getattr(kind, name).strip())
    ]
    if missing:
        raise SettingsError('effect lacks something', where=where, expected=', '.join(missing))
    if not TYPE_NAME.fullmatch(kind.type):
        raise SettingsError(
            'type is no name', where=where, found=kind.type, expected='such as cable_to_ground'
        )
    _told(lambda: kind.in_words('here', {}), where.inside('says'))
    return guarded(kind, where)
