"""`ama compare`: the modes of two recordings, such as at rest and at work, and what changed."""

from pathlib import Path
from typing import Annotated

import typer

from autonomous_modal_analysis.option_groups import grouped, Identifier
from autonomous_modal_analysis.options import Json


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('compare')(grouped(compare))


def compare(
    first: Annotated[
        Path,
        typer.Argument(help='Recording, or results of `ama identify`.', show_default=False),
    ],
    second: Annotated[Path, typer.Argument(help='The same, later.', show_default=False)],
    identifier: Identifier,
    json: Json = False,
) -> None:
    """Compare the modes of two recordings: at rest and at work, before and after.

    Modes are paired by frequency and shape; each change is told from scatter by the standard
    deviations of both.
    """
    from autonomous_modal_analysis.change_view import changes_json, show_changes
    from autonomous_modal_analysis.read_results import modes_of
    from autonomous_modal_analysis.terminal import print_json
    from oma_identifier.compare import compare as paired

    found = paired(modes_of(first, identifier), modes_of(second, identifier))
    if json:
        print_json(changes_json(found))
    else:
        show_changes(found, first.name, second.name)
