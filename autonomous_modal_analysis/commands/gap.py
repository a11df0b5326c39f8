"""`ama gap`: where simulation and measurement disagree, and what the model lacks."""

from pathlib import Path
from typing import Annotated, TYPE_CHECKING

import typer

from autonomous_modal_analysis.console.options import Effects, ExportTable, Json, LayoutPath
from modal_core.errors import SettingsError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from model_gap.quick_look import QuickLook
    from structural_model import FlexibleJointModel


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command('gap')(gap)


def gap(
    campaign: Annotated[
        Path,
        typer.Argument(help='Folder of recordings with campaign.yaml.', show_default=False),
    ],
    model: Annotated[
        str, typer.Option(help='Robot by name, its folder, or its model.yaml.', show_default=False)
    ],
    out: Annotated[
        Path, typer.Option(help='Folder for gap.json, model_updated.yaml and report.html.')
    ] = Path('gap'),
    layout: LayoutPath = None,
    effects: Effects = None,
    tolerance: Annotated[
        list[str] | None,
        typer.Option(
            help='How roughly the model is known: stiffness=0.4, "mass of link_3=0.1"; may be '
            'given more than once.',
            show_default=False,
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help='Of the draw of held-out poses.')] = 0,
    quick: Annotated[
        bool,
        typer.Option(
            '--quick',
            help='Say within seconds whether there is a gap, and where; write nothing.',
        ),
    ] = False,
    export: ExportTable = None,
    json: Json = False,
) -> None:
    """Find where simulation and measurement disagree, name the missing effect, add it.

    The verdict is `named`, `ambiguous` (with the experiment that would decide), `unexplained`
    or `none`.  A campaign of accelerations, or of motor and link encoders with torques.
    """
    import resource
    import time

    import autonomous_modal_analysis as ama
    from autonomous_modal_analysis.api.gap import campaign_of
    from autonomous_modal_analysis.console.options import stated_pair
    from autonomous_modal_analysis.console.terminal import (
        MESSAGES,
        OUTPUT,
        print_json,
        progress_bar,
    )
    from autonomous_modal_analysis.export import check_endings, TABLE_ENDINGS
    from autonomous_modal_analysis.views.output import export_each
    from modal_core.work.side_by_side import processor_time_s
    from model_gap.report import look_lines, summary_lines
    from model_gap.result_folder import ResultFolder
    from model_gap.trajectory import is_encoder_campaign
    from structural_model import load_robot

    begin_s = time.monotonic()
    check_endings(export or (), TABLE_ENDINGS)
    if export and (quick or is_encoder_campaign(campaign)):
        raise SettingsError(
            'there is no table of the gap by place',
            where='--export',
            found='--quick' if quick else 'a campaign of encoders',
        )
    sizes = dict(stated_pair(item) for item in tolerance or ())
    robot = load_robot(model)
    if quick:
        _quick_look(campaign, model, layout, effects or (), sizes, seed, json)
        return
    folder = ResultFolder(out)
    folder.prepare()
    if is_encoder_campaign(campaign):
        _encoder_gap(campaign, robot, sizes, out, json)
        return

    def tell_first(look: 'QuickLook') -> None:
        folder.write_first(robot.robot_name, look)
        MESSAGES.print(f'first look: {look_lines(look)[0]}', markup=False, soft_wrap=True)
        MESSAGES.print(f'first page: {out / "report.html"}', markup=False, soft_wrap=True)

    with progress_bar(f'reading {campaign.name}') as progress:
        data = campaign_of(campaign, model, layout, progress)
    with progress_bar('locating, naming, deciding') as progress:
        found = ama.gap(
            data,
            robot,
            effects=effects or (),
            tolerances=sizes,
            seed=seed,
            progress=progress,
            first=tell_first,
        )
    folder.write_found(found.result)
    with progress_bar('comparing mode by mode') as progress:
        folder.write_compared(found.result, found.compare(progress))
    export_each(export, found.export)
    if json:
        print_json(found.to_dict())
        return
    for line in summary_lines(found.result):
        OUTPUT.print(line, soft_wrap=True, markup=False)
    OUTPUT.print(f'written: {out / "report.html"}, gap.json, model_updated.yaml', markup=False)
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    memory_mb = max(resource.getrusage(kind).ru_maxrss for kind in kinds) / 1024.0
    OUTPUT.print(
        f'{time.monotonic() - begin_s:.0f} s, {processor_time_s():.0f} s of processor time, '
        f'{memory_mb:.0f} MB in one process at most',
        markup=False,
    )


def _quick_look(
    campaign: Path,
    model: str,
    layout: Path | None,
    effects: 'Sequence[Path]',
    sizes: dict[str, str],
    seed: int,
    json: bool,
) -> None:
    """Say whether there is a gap, and where, from the beginning of the first recordings."""
    from autonomous_modal_analysis.api.gap import campaign_of
    from autonomous_modal_analysis.console.terminal import OUTPUT, print_json, progress_bar
    from model_gap.quick_look import LIMITS, quick_look, READ
    from model_gap.report import look_lines
    from model_gap.stated import stated_settings
    from structural_model import load_robot

    robot = load_robot(model)
    with progress_bar(f'reading {campaign.name}') as progress:
        data = campaign_of(campaign, model, layout, progress, READ, LIMITS.seconds)
    settings = stated_settings(robot, data, None, effects, sizes)
    with progress_bar('looking') as progress:
        look = quick_look(robot, data, settings, seed, progress)
    if json:
        print_json(look.to_dict())
        return
    for line in look_lines(look):
        OUTPUT.print(line, soft_wrap=True, markup=False)


def _encoder_gap(
    campaign: Path, model: 'FlexibleJointModel', sizes: dict[str, str], out: Path, json: bool
) -> None:
    """Do the same for a campaign of motor and link encoders with torques."""
    from autonomous_modal_analysis.console.terminal import OUTPUT, print_json, progress_bar
    from model_gap.trajectory import (
        encoder_gap_mapping,
        EncoderFolder,
        find_encoder_gap,
        read_encoder_campaign,
        summary_lines,
    )

    data = read_encoder_campaign(campaign, model)
    with progress_bar('naming, confirming') as progress:
        found = find_encoder_gap(model, data, sizes, progress)
    EncoderFolder(out).write(found)
    if json:
        print_json(encoder_gap_mapping(found))
        return
    for line in summary_lines(found):
        OUTPUT.print(line, soft_wrap=True, markup=False)
    OUTPUT.print(f'written: {out / "report.html"}, gap.json, model_updated.yaml', markup=False)
