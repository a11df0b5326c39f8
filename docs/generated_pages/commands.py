"""The reference of the command line, out of the application itself."""

from collections.abc import Iterator
import re
from typing import Any

from generated_pages.place import cell


def commands_page() -> str:
    """Return the page of all commands of ``ama``, as Markdown without a title."""
    return '\n'.join(_lines())


def _lines() -> Iterator[str]:
    from typer.main import get_command

    from autonomous_modal_analysis.cli import app

    group: Any = get_command(app)
    for name in sorted(group.commands):
        yield from _command(name, group.commands[name], '##')


def _command(name: str, command: Any, heading: str) -> Iterator[str]:
    """Yield the part of a command; commands of a group stand below it."""
    label = name.replace(' ', '-')
    yield f'(ama-{label})=\n{heading} ama {name}\n\n{_plain(command.help)}\n'
    parts = getattr(command, 'commands', {})
    for part in sorted(parts):
        yield from _command(f'{name} {part}', parts[part], f'{heading}#')
    if not parts:
        yield f'```text\nama {name} {_usage(command.params)}\n```\n'
        yield from _table(
            'argument', [p for p in command.params if p.param_type_name == 'argument']
        )
        yield from _table('option', [p for p in command.params if p.param_type_name == 'option'])


def _usage(parameters: list[Any]) -> str:
    parts = []
    for parameter in parameters:
        if parameter.param_type_name == 'argument':
            name = parameter.name + ('...' if parameter.nargs == -1 else '')
            parts.append(name if parameter.required else f'[{name}]')
    return ' '.join([*parts, '[options]'])


def _table(kind: str, parameters: list[Any]) -> Iterator[str]:
    shown = [item for item in parameters if not getattr(item, 'hidden', False)]
    if not shown:
        return
    yield f'| {kind} | value | default | meaning |\n|---|---|---|---|'
    for item in shown:
        yield f'| {_names(item)} | {_value(item)} | {_default(item)} | {cell(_plain(item.help))} |'
    yield ''


def _names(item: Any) -> str:
    if item.param_type_name == 'argument':
        return f'`{item.name}`'
    return ', '.join(f'`{name}`' for name in (*item.opts, *item.secondary_opts))


def _value(item: Any) -> str:
    if getattr(item, 'is_flag', False):
        return ''
    # Typer 0.29 has types of its own; before, they were those of Click.
    kind = item.bare_type() if hasattr(item, 'bare_type') else item.type.name
    return cell(kind)


def _default(item: Any) -> str:
    value = item.default
    if item.required:
        return 'required'
    if value is None or value is False or value == () or callable(value):
        return ''
    return f'`{getattr(value, "value", value)}`'


def _plain(text: str | None) -> str:
    """Return help without the marks of the terminal: ``[bold]`` and the like."""
    return re.sub(r'\[/?(?:bold|dim|italic|red|green|yellow|cyan|blue)*\]', '', text or '')
