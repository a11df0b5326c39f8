"""The folder of results of an encoder campaign."""

from dataclasses import dataclass
import json
from pathlib import Path

from modal_core.files.atomic_file import write_text
from model_gap.trajectory.as_json import encoder_gap_mapping
from model_gap.trajectory.corrected import write_corrected_model
from model_gap.trajectory.encoder_gap import EncoderGap
from model_gap.trajectory.page import write_page

FOUND, REPORT = 'gap.json', 'report.html'


@dataclass(frozen=True)
class EncoderFolder:
    """Where results go.

    Parameters
    ----------
    path : Path
        There.
    """

    path: Path

    def write(self, gap: EncoderGap) -> None:
        """Write gap.json, the corrected model and the report."""
        text = json.dumps(encoder_gap_mapping(gap), indent=2, allow_nan=False, ensure_ascii=False)
        write_text(self.path / FOUND, text + '\n')
        write_corrected_model(gap, self.path)
        write_page(gap, self.path / REPORT)
