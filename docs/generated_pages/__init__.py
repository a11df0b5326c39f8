"""Pages of the documentation that follow from the code: a Sphinx extension.

When a build begins, the reference of messages, modes, parameters, commands and modules is written
anew below ``reference/generated``; a page that is included there cannot go stale.  The directives
``import-picture`` and ``measured`` draw the arrows between rooms and show results of benchmarks.
"""

from pathlib import Path
from typing import Any, NewType

from generated_pages.commands import commands_page
from generated_pages.effects import effects_page
from generated_pages.messages import messages_page
from generated_pages.mode import mode_page
from generated_pages.modules import module_pages
from generated_pages.parameters import parameters_page
from generated_pages.place import write_when_changed

FOLDER = Path('reference') / 'generated'


def write_pages(app: Any) -> None:
    """Write every generated page below the source folder; remove those that are left over."""
    folder = Path(app.srcdir) / FOLDER
    pages = {
        'messages.md': messages_page(),
        'mode.md': mode_page(),
        'parameters.md': parameters_page(),
        'commands.md': commands_page(),
        'effects.md': effects_page(),
        **{f'modules/{name}': text for name, text in module_pages().items()},
    }
    for name, text in pages.items():
        write_when_changed(folder / name, text)
    for path in folder.rglob('*.*'):
        if str(path.relative_to(folder)) not in pages:
            path.unlink()


def keep_bars(
    app: Any, what: str, name: str, item: object, options: Any, lines: list[str]
) -> None:
    """Keep ``|x|`` an absolute value: in reStructuredText bars mark a substitution."""
    for number, line in enumerate(lines):
        parts = line.split('``')
        parts[::2] = [part.replace('|', r'\|') for part in parts[::2]]
        lines[number] = '``'.join(parts)


def leave_out_new_types(
    app: Any, what: str, name: str, item: object, skip: bool, options: Any
) -> bool | None:
    """Leave out names made by ``NewType``: numpydoc takes them for classes and fails."""
    return True if isinstance(item, NewType) else None


def setup(app: Any) -> dict[str, bool]:
    """Register the pages and the directives."""
    # Here, so that tests read the pages without Sphinx.
    from generated_pages.directives import ImportPicture, Measured

    app.connect('builder-inited', write_pages)
    app.connect('autodoc-skip-member', leave_out_new_types)
    app.connect('autodoc-process-docstring', keep_bars, priority=900)
    app.add_directive('import-picture', ImportPicture)
    app.add_directive('measured', Measured)
    return {'parallel_read_safe': True, 'parallel_write_safe': True}
