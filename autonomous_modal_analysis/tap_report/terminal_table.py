"""A tap test on the terminal."""

from rich.markup import escape
from rich.table import Table

from autonomous_modal_analysis.console.terminal import OUTPUT
from impact_testing import ImpactResult
from modal_reports import DAMPING, fixed, FREQUENCY, MPC, Quantity

MASS = Quantity('modal mass', 'kg')


def show_tap_test(found: ImpactResult, name: str) -> None:
    """Print modes, taps that were left out, and remarks."""
    table = Table(title=escape(name), title_justify='left')
    for heading in (FREQUENCY.label, DAMPING.label, MASS.label, MPC.label):
        table.add_column(escape(heading), justify='right')
    for each in found.scaled_modes:
        mode = each.mode
        table.add_row(
            FREQUENCY.number(mode.frequency_hz, mode.frequency_std_hz),
            DAMPING.number(mode.damping_ratio, mode.damping_ratio_std),
            MASS.number(each.modal_mass_kg, each.modal_mass_std_kg),
            fixed(mode.mpc, 3),
        )
    OUTPUT.print(table)
    for point in found.points:
        for recording, number, _, tap in point.told_taps():
            if not tap.good:
                said = f'{recording}, tap {number} left out: {tap.words}'
                OUTPUT.print(escape(said), soft_wrap=True)
    for remark in found.remarks:
        OUTPUT.print(f'note: {escape(remark)}', soft_wrap=True)
