# SPDX-License-Identifier: BSD-2-Clause
"""lidar.py INTERFACE: a lidar on the Cyphal bus, for trying the rover out. Each line of standard input is a distance in
centimetres (0 to 255); until the next line comes it sends scans with that as the nearest one, ten a second."""
import binascii
import select
import socket
import struct
import sys

ID = socket.CAN_EFF_FLAG | 4 << 26 | 3 << 21 | 1234 << 8 | 0x2A  # priority 4, subject 1234, node 42
PERIOD = 0.1
CHUNK = 7  # octets of a classic frame beside its tail


def frames(event, number):
    """The frames of a transfer, Cyphal Specification 1.0, 4.2; `event` is longer than one frame."""
    octets = event + binascii.crc_hqx(event, 0xFFFF).to_bytes(2, "big")
    parts = [octets[i:i + CHUNK] for i in range(0, len(octets), CHUNK)]
    for i, part in enumerate(parts):
        first, last, toggle = i == 0, i == len(parts) - 1, i % 2 == 0
        yield part + bytes([first << 7 | last << 6 | toggle << 5 | number % 32])


bus = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
bus.bind((sys.argv[1],))
nearest, number = None, 0
while True:
    if select.select([sys.stdin], [], [], PERIOD)[0]:
        line = sys.stdin.readline()
        if not line:
            break
        nearest = int(line)
    if nearest is not None:
        for frame in frames(bytes([nearest] + [255] * 23), number):
            bus.send(struct.pack("=IB3x8s", ID, len(frame), frame))
        number += 1
