"""Parameters of the planner node: names, meaning, ranges; one for every field of a request."""

from collections.abc import Iterator
from dataclasses import dataclass, fields, MISSING

from excitation_planner.request import PlanRequest

RATIO_OR_TIME = (1e-6, 3600.0)


@dataclass(frozen=True, slots=True)
class PlannerParameter:
    """One parameter of the node.

    Parameters
    ----------
    name, text : str
        What it is.
    default : value
        Also gives the type; an empty tuple is a list that is not set.
    span : (low, high) tuple or None
        Range of a number.
    read_only : bool
        Cannot be changed while the node runs.
    """

    name: str
    default: bool | int | float | str | tuple[()]
    text: str
    span: tuple[float, float] | None = None
    read_only: bool = False


_P = PlannerParameter
OWN = (
    _P('robot', 'irb6660_205_190', 'robot of config/robots, or its folder', read_only=True),
    _P('sensors', 'sensors', 'sensor layout of the robot', read_only=True),
    _P('plan_on_start', True, 'plan as soon as the node is up'),
    _P('closed_loop', False, 'plan the next window after each modal_parameters'),
    _P('start_pose', '', 'named pose to start at; empty: start_position, or the first pose'),
    _P(
        'target_frequency_std_ratio',
        0.002,
        'closed loop stops when every σ_f/f is below',
        RATIO_OR_TIME,
    ),
    _P(
        'target_damping_ratio_std_ratio',
        0.1,
        'closed loop stops when every σ_ζ/ζ is below',
        RATIO_OR_TIME,
    ),
    _P('longest_window_s', 300.0, 'closed loop: no window gets longer [s]', RATIO_OR_TIME),
)


def _of_request() -> Iterator[PlannerParameter]:
    for item in fields(PlanRequest):
        default = item.default if item.default is not MISSING else ()
        yield _P(item.name, default, item.metadata['description'], item.metadata.get('range'))


PARAMETERS = (*OWN, *_of_request())
