"""A finger on a key: writes it to a terminal again and again until it is killed.

A process of its own, as a keyboard is: in the tests' own process a collection of garbage, which
takes 0.2 s with all tests loaded, would let the key go.  Needs nothing but the standard library.
"""

import os
import sys
import time

FIRST_DELAY_S, REPEAT_S = 0.5, 1.0 / 30.0


def main(descriptor: int, key: bytes) -> None:
    """Write a stroke, wait, then repeats as long as there is a terminal."""
    os.write(descriptor, key)
    due_s = time.monotonic() + FIRST_DELAY_S
    while True:
        time.sleep(max(due_s - time.monotonic(), 0.0))
        os.write(descriptor, key)
        due_s = max(due_s + REPEAT_S, time.monotonic())


if __name__ == '__main__':
    main(int(sys.argv[1]), sys.argv[2].encode())
