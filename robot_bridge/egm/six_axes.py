"""Externally Guided Motion moves arms of six axes."""

from collections.abc import Sequence

from modal_core.errors import BridgeError
from robot_bridge.egm.egm_messages import MAX_JOINTS


def check_six_axes(joint_names: Sequence[str], robot: str) -> None:
    """Refuse an arm of another number of joints.

    Raises
    ------
    BridgeError
        With the number.
    """
    if len(joint_names) != MAX_JOINTS:
        raise BridgeError(
            'Externally Guided Motion moves six axes',
            where=robot,
            found=f'{len(joint_names)} joints',
            expected=MAX_JOINTS,
            advice='record it with ama campaign, by its own driver, or with recordings',
        )
