"""Parameters of the planner node: names, meaning, ranges; one for every field of a request."""

from excitation_planner.request import PlanRequest
from modal_core.settings.node_parameter import NodeParameter, parameters_of

RATIO_OR_TIME = (1e-6, 3600.0)
OWN = (
    NodeParameter(
        'robot', 'robot of config/robots, or its folder', 'irb6660_205_190', read_only=True
    ),
    NodeParameter('sensors', 'sensor layout of the robot', 'sensors', read_only=True),
    NodeParameter('plan_on_start', 'plan as soon as the node is up', True),
    NodeParameter('closed_loop', 'plan the next window after each modal_parameters', False),
    NodeParameter(
        'predicted_modes_topic',
        'topic of the modes a map predicts: where it knows the start of a plan, these are excited;'
        ' empty: those of the model',
        'modal_map/predicted_modes',
        read_only=True,
    ),
    NodeParameter(
        'start_pose', 'named pose to start at; empty: start_position, or the first pose', ''
    ),
    NodeParameter(
        'target_frequency_std_ratio',
        'closed loop stops when every σ_f/f is below',
        0.002,
        *RATIO_OR_TIME,
    ),
    NodeParameter(
        'target_damping_ratio_std_ratio',
        'closed loop stops when every σ_ζ/ζ is below',
        0.1,
        *RATIO_OR_TIME,
    ),
    NodeParameter(
        'longest_window_s', 'closed loop: no window gets longer [s]', 300.0, *RATIO_OR_TIME
    ),
)
REQUEST = parameters_of(PlanRequest)
PARAMETERS = (*OWN, *REQUEST)
