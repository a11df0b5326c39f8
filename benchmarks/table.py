"""One line of the table: ours beside the peer's, what is to be reached, and whether it is."""

from dataclasses import dataclass

HEADER = '| what | ours | peer | ratio | reach | |\n|---|---|---|---|---|---|'


@dataclass(frozen=True)
class Line:
    """One measured figure; ``met`` None: nothing was asked for."""

    what: str
    ours: str
    peer: str = '-'
    ratio: str = '-'
    reach: str = '-'
    met: bool | None = None

    def markdown(self) -> str:
        """Return the line of the table."""
        verdict = {True: 'ok', False: '**short**', None: ''}[self.met]
        cells = (self.what, self.ours, self.peer, self.ratio, self.reach, verdict)
        return f'| {" | ".join(cells)} |'
