"""Modules that are not installed: which, and what installs them, in one line."""

from importlib.util import find_spec

from modal_core.errors import ModalAnalysisError

EXIT_MISSING = 2
MESSAGES = 'oma_msgs'
ROS = frozenset(
    (
        'builtin_interfaces',
        'diagnostic_msgs',
        'geometry_msgs',
        'lifecycle_msgs',
        'rcl_interfaces',
        'rclpy',
        'rosgraph_msgs',
        'rosidl_parser',
        'rpyutils',
        'sensor_msgs',
        'std_msgs',
        'std_srvs',
        'tf2_msgs',
        'trajectory_msgs',
        'visualization_msgs',
    )
)
SHARED_OBJECT = '.so'
WORKSPACE = 'in a ROS workspace: . install/setup.bash'
INSTALL_ROS = (
    "install it with: pip install 'ros-jazzy-rclpy[fastrtps]' ros-jazzy-common-interfaces"
    f', then ./oma_msgs of the source tree; {WORKSPACE}'
)
INSTALL_MESSAGES = (
    f'install them from the source tree of this version with: pip install ./oma_msgs; {WORKSPACE}'
)


class MissingError(ModalAnalysisError):
    """A package that is needed is not installed, or only in part."""


def explain(error: ImportError) -> MissingError | None:
    """Return what to install after a failed import; None when nothing installs it.

    Parameters
    ----------
    error : ImportError
        What a command or node ended with.
    """
    package = (error.name or '').partition('.')[0]
    if not package and SHARED_OBJECT in str(error):
        return MissingError(
            'a library that ROS 2 Jazzy needs cannot be loaded',
            found=str(error).splitlines()[0],
            advice=f'start it where ROS is set up; {WORKSPACE}',
        )
    if package == MESSAGES and find_spec('rclpy') is not None:
        return MissingError(
            'the messages oma_msgs of this version are not installed',
            found=error,
            advice=INSTALL_MESSAGES,
        )
    if package in (MESSAGES, *ROS):
        return MissingError('ROS 2 Jazzy is not installed', found=error, advice=INSTALL_ROS)
    if isinstance(error, ModuleNotFoundError) and find_spec(package) is None:
        return MissingError(
            'a Python package is not installed',
            found=error,
            advice='install the suite with what it needs: pip install . in its source tree',
        )
    return None
