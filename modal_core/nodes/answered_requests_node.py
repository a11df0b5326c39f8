"""No request ends a node: one that cannot be answered is told, and answered with nothing.

Executors let what a callback raises end the process.  ROS itself serves parameters and the life
cycle so: a parameter of a type that does not exist, or a transition that is not possible now, from
anybody in the network, would end the node and whatever it does for others.
"""

from functools import partial
from typing import Any

from rclpy.node import Node
from rclpy.service import Service

from modal_core.errors import MessageError


def answer_all_requests(node: Node) -> None:
    """Let every service a node has now answer whatever is asked of it."""
    for service in node.services:
        service.callback = partial(_answer, node, service, service.callback)


def _answer(node: Node, service: Service, callback: Any, request: Any, response: Any) -> Any:
    try:
        return callback(request, response)
    except Exception as error:
        if not node.context.ok():
            raise  # told to stop meanwhile
        found = f'{type(error).__name__}: {error}'
        refused = MessageError('a request cannot be answered', where=service.srv_name, found=found)
        node.get_logger().error(str(refused))
        return service.srv_type.Response()
