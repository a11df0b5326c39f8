"""A process that behaves as ROS 2's joint_trajectory_controller and joint_state_broadcaster do.

As its documentation says it: goals are refused unless their joints are its own, their times rise
and they end at rest; between points it goes on polynomials of degree five, of which it commands a
value at each update; a joint farther from there than the path tolerance ends the goal
(PATH_TOLERANCE_VIOLATED), one not within the goal tolerance in time too; cancelled, it holds where
the joints are.  The joints follow as a first order does.  It shares no code with the bridge.
"""

import contextlib
import itertools
import math
import threading
import time

import rclpy
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node
from rclpy.time import Time
from sensor_msgs.msg import JointState

from control_msgs.action import FollowJointTrajectory
from modal_core.nodes.run_node import RCLError

Result = FollowJointTrajectory.Result


def quintic(p0, v0, a0, p1, v1, a1, length, t):
    """Return position on the polynomial of degree five, by its coefficients in t."""
    h = length
    c3 = (20 * (p1 - p0) - (8 * v1 + 12 * v0) * h - (3 * a0 - a1) * h * h) / (2 * h**3)
    c4 = (30 * (p0 - p1) + (14 * v1 + 16 * v0) * h + (3 * a0 - 2 * a1) * h * h) / (2 * h**4)
    c5 = (12 * (p1 - p0) - 6 * (v1 + v0) * h - (a0 - a1) * h * h) / (2 * h**5)
    return p0 + v0 * t + a0 / 2 * t**2 + c3 * t**3 + c4 * t**4 + c5 * t**5


class Controller(Node):
    def __init__(self):
        super().__init__('joint_trajectory_controller')
        for name, value in (
            ('joints', ['']), ('start', [0.0]), ('rate_hz', 100.0), ('lag_s', 0.01),
            ('path_tolerance', 0.05), ('goal_tolerance', 0.001), ('stuck_after_s', 1e9),
            ('accepts', True), ('silent_after_s', 1e9), ('answers_after_s', 0.0),
        ):  # fmt: skip
            self.declare_parameter(name, value)
        self.joints = list(self.value('joints'))
        self.actual = [float(v) for v in self.value('start')]
        self.command = list(self.actual)
        self.lock, self.goal = threading.Lock(), None
        self.states = self.create_publisher(JointState, 'joint_states', 10)
        group = ReentrantCallbackGroup()
        self.server = ActionServer(
            self, FollowJointTrajectory, 'joint_trajectory_controller/follow_joint_trajectory',
            execute_callback=self.execute, goal_callback=self.consider,
            cancel_callback=lambda _: CancelResponse.ACCEPT, callback_group=group,
        )  # fmt: skip
        threading.Thread(target=self.update, daemon=True).start()

    def value(self, name):
        return self.get_parameter(name).value

    def consider(self, request):
        time.sleep(self.value('answers_after_s'))
        points = request.trajectory.points
        times = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in points]
        right = (
            self.value('accepts')
            and sorted(request.trajectory.joint_names) == sorted(self.joints)
            and points
            and all(b > a for a, b in itertools.pairwise(times))
            and not any(points[-1].velocities)
        )
        return GoalResponse.ACCEPT if right else GoalResponse.REJECT

    def execute(self, handle):
        trajectory = handle.request.trajectory
        order = [trajectory.joint_names.index(name) for name in self.joints]
        begin = Time.from_msg(trajectory.header.stamp).nanoseconds
        with self.lock:
            # Until the first point it comes from where it was when the goal came.
            early_s = min(1e-9 * (self.get_clock().now().nanoseconds - begin), -1e-3)
            first = (early_s, list(self.command), [0.0] * len(order), [0.0] * len(order))
            points = [first] + [
                (
                    p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec,
                    *([row[k] for k in order] for row in
                      (p.positions, p.velocities, p.accelerations)),
                )
                for p in trajectory.points
            ]  # fmt: skip
            goal = self.goal = {'points': points, 'begin': begin, 'end': None, 'k': 0}
        while goal['end'] is None and not handle.is_cancel_requested and rclpy.ok():
            time.sleep(0.005)
        result = Result()
        with self.lock:
            self.goal = None
            if goal['end'] is None:
                self.command = list(self.actual)
        if goal['end'] is None:
            handle.canceled()
        elif goal['end'][0] == Result.SUCCESSFUL:
            handle.succeed()
        else:
            handle.abort()
        if goal['end'] is not None:
            result.error_code, result.error_string = goal['end']
        return result

    def update(self):
        period_s = 1.0 / self.value('rate_hz')
        share = 1.0 - math.exp(-period_s / max(self.value('lag_s'), 1e-9))
        due = time.monotonic()
        while rclpy.ok():
            now_ns = self.get_clock().now().nanoseconds
            with self.lock:
                elapsed_s = self.follow(now_ns)
                if elapsed_s < self.value('stuck_after_s'):
                    self.actual = [
                        a + share * (c - a)
                        for a, c in zip(self.actual, self.command, strict=False)
                    ]
                state = JointState(name=self.joints, position=self.actual)
            if elapsed_s < self.value('silent_after_s'):
                state.header.stamp = Time(nanoseconds=now_ns).to_msg()
                with contextlib.suppress(RCLError):
                    self.states.publish(state)
            due += period_s
            time.sleep(max(due - time.monotonic(), 0.0))

    def follow(self, now_ns):
        goal = self.goal
        if goal is None or goal['end'] is not None:
            return 0.0
        elapsed_s = 1e-9 * (now_ns - goal['begin'])
        points = goal['points']
        while goal['k'] < len(points) - 2 and points[goal['k'] + 1][0] <= elapsed_s:
            goal['k'] += 1
        (t0, *before), (t1, *after) = points[goal['k']], points[goal['k'] + 1]
        at = min(elapsed_s, t1) - t0
        self.command = [
            quintic(*(row[j] for row in before), *(row[j] for row in after), t1 - t0, at)
            for j in range(len(self.joints))
        ]
        away = [abs(a - c) for a, c in zip(self.actual, self.command, strict=False)]
        worst = max(range(len(away)), key=away.__getitem__)
        if away[worst] > self.value('path_tolerance'):
            self.command = list(self.actual)
            text = f'{self.joints[worst]} is {away[worst]:.4f} away'
            goal['end'] = (Result.PATH_TOLERANCE_VIOLATED, text)
        elif elapsed_s > points[-1][0] and away[worst] <= self.value('goal_tolerance'):
            goal['end'] = (Result.SUCCESSFUL, '')
        elif elapsed_s > points[-1][0] + 1.0:
            goal['end'] = (Result.GOAL_TOLERANCE_VIOLATED, f'{self.joints[worst]}')
        return elapsed_s


def main():
    rclpy.init()
    node = Controller()
    executor = MultiThreadedExecutor(4)
    executor.add_node(node)
    try:
        executor.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


if __name__ == '__main__':
    main()
