"""A man in the middle of the EGM link: passes datagrams on, keeps them all, can go deaf."""

import select
import socket
import threading
import time


class UdpTap:
    """Stands between controller and bridge; the controller sends to ``address``."""

    def __init__(self, bridge):
        self.front = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.back = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        for end in (self.front, self.back):
            end.bind(('127.0.0.1', 0))
            end.setblocking(False)
        self.address, self.bridge = self.front.getsockname(), bridge
        self.robot, self.sensor = [], []  # (time, data)
        self._controller = None
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        while not self._closing.is_set():
            ready, _, _ = select.select([self.front, self.back], [], [], 0.1)
            for end in ready:
                try:
                    data, sender = end.recvfrom(4096)
                except OSError:  # nobody behind: the kernel says so once
                    continue
                if end is self.front:
                    self._controller = sender
                    self.robot.append((time.monotonic(), data))
                    self.back.sendto(data, self.bridge)
                elif self._controller is not None:
                    self.sensor.append((time.monotonic(), data))
                    self.front.sendto(data, self._controller)

    def close(self):
        self._closing.set()
        self._thread.join()
        self.front.close()
        self.back.close()
