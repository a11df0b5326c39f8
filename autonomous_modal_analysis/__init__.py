"""Operational modal analysis in Python: natural frequencies, damping ratios, mode shapes, and σ.

``identify`` takes an array, ``open`` a recording, ``batch`` many, ``merge`` joins set-ups of
roving sensors, ``impact`` takes taps of a hammer, ``lobes`` finds the cut that does not chatter,
``plan`` plans a motion that shakes every mode, ``model`` says what the model of a robot has in a
pose, ``gap`` where model and measurement disagree, and ``history`` what changed over months.
Importing the package loads nothing of this; what is used is loaded when it is used.

>>> import autonomous_modal_analysis as ama
>>> ama.__all__[:5]
['Batch', 'History', 'LobesResult', 'MergedResult', 'ModalAnalysisError']
"""

from importlib import import_module
from typing import Any, TYPE_CHECKING

if TYPE_CHECKING:
    from autonomous_modal_analysis.api.array import identify as identify
    from autonomous_modal_analysis.api.batch import Batch as Batch
    from autonomous_modal_analysis.api.batch import batch as batch
    from autonomous_modal_analysis.api.gap import gap as gap
    from autonomous_modal_analysis.api.gap import ModelGap as ModelGap
    from autonomous_modal_analysis.api.history import History as History
    from autonomous_modal_analysis.api.history import history as history
    from autonomous_modal_analysis.api.history import Trends as Trends
    from autonomous_modal_analysis.api.impact import impact as impact
    from autonomous_modal_analysis.api.impact import TapTest as TapTest
    from autonomous_modal_analysis.api.lobes import lobes as lobes
    from autonomous_modal_analysis.api.lobes import LobesResult as LobesResult
    from autonomous_modal_analysis.api.merge import merge as merge
    from autonomous_modal_analysis.api.merge import MergedResult as MergedResult
    from autonomous_modal_analysis.api.modal_result import ModalResult as ModalResult
    from autonomous_modal_analysis.api.model import model as model
    from autonomous_modal_analysis.api.model import ModelAtPose as ModelAtPose
    from autonomous_modal_analysis.api.plan import plan as plan
    from autonomous_modal_analysis.api.plan import PlannedMotion as PlannedMotion
    from autonomous_modal_analysis.api.recording import open_recording as open  # noqa: A004
    from autonomous_modal_analysis.api.recording import Recording as Recording
    from modal_core.errors import ModalAnalysisError as ModalAnalysisError

    __version__: str

# Public name to module and name there.
_LAZY = {
    'Batch': ('autonomous_modal_analysis.api.batch', 'Batch'),
    'History': ('autonomous_modal_analysis.api.history', 'History'),
    'LobesResult': ('autonomous_modal_analysis.api.lobes', 'LobesResult'),
    'MergedResult': ('autonomous_modal_analysis.api.merge', 'MergedResult'),
    'ModalAnalysisError': ('modal_core.errors', 'ModalAnalysisError'),
    'ModalResult': ('autonomous_modal_analysis.api.modal_result', 'ModalResult'),
    'ModelAtPose': ('autonomous_modal_analysis.api.model', 'ModelAtPose'),
    'ModelGap': ('autonomous_modal_analysis.api.gap', 'ModelGap'),
    'PlannedMotion': ('autonomous_modal_analysis.api.plan', 'PlannedMotion'),
    'Recording': ('autonomous_modal_analysis.api.recording', 'Recording'),
    'TapTest': ('autonomous_modal_analysis.api.impact', 'TapTest'),
    'Trends': ('autonomous_modal_analysis.api.history', 'Trends'),
    'batch': ('autonomous_modal_analysis.api.batch', 'batch'),
    'gap': ('autonomous_modal_analysis.api.gap', 'gap'),
    'history': ('autonomous_modal_analysis.api.history', 'history'),
    'identify': ('autonomous_modal_analysis.api.array', 'identify'),
    'impact': ('autonomous_modal_analysis.api.impact', 'impact'),
    'lobes': ('autonomous_modal_analysis.api.lobes', 'lobes'),
    'merge': ('autonomous_modal_analysis.api.merge', 'merge'),
    'model': ('autonomous_modal_analysis.api.model', 'model'),
    'open': ('autonomous_modal_analysis.api.recording', 'open_recording'),
    'plan': ('autonomous_modal_analysis.api.plan', 'plan'),
}
__all__ = [
    'Batch',
    'History',
    'LobesResult',
    'MergedResult',
    'ModalAnalysisError',
    'ModalResult',
    'ModelAtPose',
    'ModelGap',
    'PlannedMotion',
    'Recording',
    'TapTest',
    'Trends',
    'batch',
    'gap',
    'history',
    'identify',
    'impact',
    'lobes',
    'merge',
    'model',
    'open',
    'plan',
]


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used (PEP 562)."""
    if name == '__version__':
        from modal_core.files.version import suite_version

        return suite_version()
    if name not in _LAZY:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    module, attribute = _LAZY[name]
    value = getattr(import_module(module), attribute)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names also before they are loaded."""
    return sorted({*globals(), *__all__, '__version__'})
