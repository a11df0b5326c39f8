"""A joystick as ``joy_node`` tells of it, in a process of its own as that is.

``python -m test.support.joystick TOPIC N``: publishes N buttons 20 times a second, the last of
them as the last line of standard input says, ``1`` down and ``0`` up; ends with its input.
"""

import os
import sys
import time

PERIOD_S = 0.05
MOST_BYTES = 4096


def main(topic: str, n_buttons: int) -> None:
    """Publish until standard input ends."""
    import rclpy
    from sensor_msgs.msg import Joy

    rclpy.init()
    publisher = rclpy.create_node('pad').create_publisher(Joy, topic, 10)
    os.set_blocking(sys.stdin.fileno(), False)
    pressed = 0
    while True:
        try:
            told = os.read(sys.stdin.fileno(), MOST_BYTES)
        except BlockingIOError:
            pass
        else:
            if not told:
                rclpy.try_shutdown()
                return
            pressed = int(told.split()[-1])
        publisher.publish(Joy(buttons=[0] * (n_buttons - 1) + [pressed]))
        time.sleep(PERIOD_S)


if __name__ == '__main__':
    main(sys.argv[1], int(sys.argv[2]))
