"""The folder of results: what was found at once, the comparison and the report when they are done.

Whatever ends the work, gap.json and the report are of one search; a corrected model stays until
there is another, since it may be the one that is searched with.
"""

from dataclasses import dataclass
from pathlib import Path
import tempfile

from model_gap.comparison import ModelComparison
from model_gap.find_gap import GapResult
from model_gap.gap_json import write_gap_json
from model_gap.quick_look import QuickLook
from model_gap.report import COMPARING, effect_words, FirstPage, headline, write_report
from model_gap.updated_model import write_updated_model

FOUND, REPORT = 'gap.json', 'report.html'


@dataclass(frozen=True)
class ResultFolder:
    """Where results go.

    Parameters
    ----------
    path : Path
        Made when missing.
    """

    path: Path

    def prepare(self) -> None:
        """Make the folder.

        Raises
        ------
        OSError
            It cannot be made or written to: better known before the work than after.
        """
        self.path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=self.path):
            pass

    def write_first(self, robot: str, look: QuickLook) -> None:
        """Write a first page in the report's place; what an older search found goes."""
        (self.path / FOUND).unlink(missing_ok=True)
        FirstPage.of_look(robot, look).write(self.path / REPORT)

    def write_found(self, result: GapResult) -> None:
        """Write gap.json without the comparison, the corrected model and a page of the verdict."""
        (self.path / REPORT).unlink(missing_ok=True)
        write_gap_json(result, self.path / FOUND)
        FirstPage(
            result.search.model.robot_name,
            headline(result),
            (*effect_words(result), *result.decision.reasons),
            result.decision.experiments,
            COMPARING,
        ).write(self.path / REPORT)
        write_updated_model(result, self.path)

    def write_compared(self, result: GapResult, comparison: ModelComparison) -> None:
        """Write gap.json with the comparison, and the report."""
        write_gap_json(result, self.path / FOUND, comparison)
        write_report(result, self.path / REPORT, comparison)
