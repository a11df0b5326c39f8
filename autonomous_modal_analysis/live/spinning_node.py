"""ROS nodes that spin in a thread beside the command line."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
import os
import random
import threading
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from modal_core.nodes.answered_requests_node import answer_all_requests

LOWEST_DOMAIN, HIGHEST_DOMAIN = 1, 101


def own_domain() -> dict[str, str]:
    """Return environment variables that put processes into a ROS domain of their own."""
    # Not for secrecy: any domain that is probably not in use will do.
    domain = random.SystemRandom().randint(LOWEST_DOMAIN, HIGHEST_DOMAIN)
    return {'ROS_DOMAIN_ID': str(domain), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST'}


@contextmanager
def ros_context(environment: Mapping[str, str] | None = None) -> Iterator[rclpy.Context]:
    """Yield an rclpy context, in the domain the environment variables name."""
    if environment:
        os.environ.update(environment)
    context = rclpy.Context()
    # Signals stay with the command line: Ctrl-C must first stop the robot, then the nodes.
    rclpy.init(context=context, signal_handler_options=rclpy.SignalHandlerOptions.NO)
    try:
        yield context
    finally:
        rclpy.try_shutdown(context=context)


@contextmanager
def spinning(node: Node) -> Iterator[Any]:
    """Spin a node in a thread of its own while the block runs."""
    answer_all_requests(node)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    thread = threading.Thread(target=_spin, args=(executor,), name='ros', daemon=True)
    thread.start()
    try:
        yield node
    finally:
        executor.shutdown(timeout_sec=1.0)
        thread.join(timeout=2.0)
        node.destroy_node()


def _spin(executor: SingleThreadedExecutor) -> None:
    try:
        executor.spin()
    except ExternalShutdownException:
        return
