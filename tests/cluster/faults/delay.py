# SPDX-License-Identifier: BSD-2-Clause
"""A place whose link to the store is slow, in both directions, on kernels without netem too: frames pass through this
program while that lasts. Connections that exist stay."""
import collections
import select
import socket
import struct
import threading
import time

ETH_P_ALL = 3
SOL_PACKET, PACKET_VNET_HDR, PACKET_IGNORE_OUTGOING = 263, 15, 23
LONGEST_FRAME = 1 << 17  # segments that a later stage cuts, with what that stage must know of them in front


def socket_on(link):
    one = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
    for option in (PACKET_VNET_HDR, PACKET_IGNORE_OUTGOING):
        one.setsockopt(SOL_PACKET, option, struct.pack("i", 1))
    one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    one.setblocking(False)
    one.bind((link, ETH_P_ALL))
    return one


class Delay:
    """Of s-PLACE, in place of the bridge: d-PLACE has the other end b-PLACE there."""

    def __init__(self, place, seconds, sh):
        self.place, self.seconds, self.sh = place, seconds, sh
        self.frames = 0
        self.ends = False
        self.near, self.far = socket_on(f"s-{place}"), socket_on(f"d-{place}")
        sh(f"ip link set s-{place} nomaster && ip link set b-{place} master store")
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        waiting = collections.deque()  # (when, where to, frame): the delay is the same for all
        other = {self.near: self.far, self.far: self.near}
        while not self.ends:
            patience = min(0.1, max(0.0, waiting[0][0] - time.monotonic())) if waiting else 0.1
            for one in select.select(list(other), [], [], patience)[0]:
                frame = self.receive(one)
                if frame:
                    waiting.append((time.monotonic() + self.seconds, other[one], frame))
            while waiting and waiting[0][0] <= time.monotonic():
                self.send(*waiting.popleft()[1:])
        for _, to, frame in waiting:
            self.send(to, frame)

    @staticmethod
    def receive(one):
        try:
            return one.recv(LONGEST_FRAME)
        except OSError:
            return b""

    def send(self, to, frame):
        try:
            to.send(frame)
            self.frames += 1
        except OSError:
            pass  # a full queue: it is lost, as on any link

    def end(self):
        """What is still on the way arrives at once."""
        self.ends = True
        self.thread.join()
        self.sh(f"ip link set b-{self.place} nomaster && ip link set s-{self.place} master store")
        self.near.close()
        self.far.close()
