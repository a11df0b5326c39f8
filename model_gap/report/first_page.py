"""What can be said while the work goes on: a quick look, then the verdict without its pictures."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from modal_core.files.atomic_file import write_text
from modal_reports import capital, Page, render
from model_gap.quick_look import QuickLook, State

TEMPLATE = Path(__file__).parent / 'templates' / 'first_page.html.j2'
STYLES = (Path(__file__).parent / 'templates' / 'gap.css',)
HEADLINES = {
    State.HEALTHY: 'Model and robot agree as far as a first look tells',
    State.UNCLEAR: 'No clear gap at first look; something small may be missing',
    State.GAP: 'There is a gap between model and robot',
}
SEARCHING = 'This is a first look: causes are being sought. The report takes its place.'
COMPARING = 'This is the verdict: pictures and tables are being made. The report takes its place.'


@dataclass(frozen=True)
class FirstPage:
    """A page that the report replaces when it is done.

    Parameters
    ----------
    robot : str
        Name.
    headline : str
        One sentence.
    lines, following : sequence of str
        What else is known, and what to record next.
    going_on : str
        What is being done.
    """

    robot: str
    headline: str
    lines: Sequence[str]
    following: Sequence[str]
    going_on: str

    @classmethod
    def of_look(cls, robot: str, look: QuickLook) -> 'FirstPage':
        """Return the page of a quick look."""
        lines = (*look.reasons, *look.where, *_notes(look))
        return cls(
            robot, HEADLINES[look.state], tuple(dict.fromkeys(lines)), look.following, SEARCHING
        )

    def write(self, path: Path) -> None:
        """Write the page, whole or not at all."""
        values = {
            'headline': self.headline,
            'lines': self.lines,
            'following': self.following,
            'going_on': self.going_on,
            'capital': capital,
        }
        title = f'Model gap: {self.robot}'
        write_text(
            path, render(Page('Model gap, first page', title, TEMPLATE, values, None, STYLES))
        )


def look_lines(look: QuickLook) -> list[str]:
    """Return what the command line prints of a quick look."""
    lines = [f'{look.state.value}: {HEADLINES[look.state]}']
    lines += [f'  because {line}' for line in look.reasons]
    lines += [f'  where: {line}' for line in look.where if line not in look.reasons]
    lines += [f'  next: {line}' for line in look.following]
    return lines + _notes(look)


def _notes(look: QuickLook) -> list[str]:
    return [f'note: {line}' for line in look.notes]
