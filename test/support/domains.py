"""ROS domains that keep tests apart from one another and from other runs on the machine."""

import os

MOST_DOMAINS, OF_ONE_WORKER = 100, 50


def ros_domain(turn: int = 0) -> int:
    """Return a ROS domain id of this process; other turns give others.

    Two workers of pytest-xdist never get the same one.
    """
    worker = os.environ.get('PYTEST_XDIST_WORKER', '')
    run = os.getppid() if worker else os.getpid()
    of_worker = OF_ONE_WORKER * int(worker.removeprefix('gw') or 0)
    return 1 + (run + of_worker + turn % OF_ONE_WORKER) % MOST_DOMAINS
