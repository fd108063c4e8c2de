# SPDX-License-Identifier: BSD-2-Clause
"""A node of FAMOUSO on UDP multicast without a gateway of its own, such as a control PC. It needs nothing of MLCCA.
  famouso_node.py ADDRESS send SUBJECT COUNT MS   COUNT numbered events of 7 bytes, one each MS milliseconds
  famouso_node.py ADDRESS display SUBJECT...      a line "SUBJECT HEX" for each event that comes
ADDRESS is that of the interface, SUBJECT a number as in the description."""
import socket
import sys
import time

PORT = 9999


def group(subject):
    """The multicast group of a subject, as FAMOUSO has it."""
    octets = subject.to_bytes(8, "big")
    return f"239.{octets[0]}.{octets[7]}.{min(max(octets[5], 1), 254)}"


own, role, *words = sys.argv[1:]
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(own))
s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 0)
if role == "send":
    subject, count, period = int(words[0], 0), int(words[1]), int(words[2]) / 1000
    due = time.monotonic()
    for number in range(count):
        s.sendto(subject.to_bytes(8, "big") + b"\0%07d" % number, (group(subject), PORT))
        due = max(due + period, time.monotonic())
        time.sleep(max(0, due - time.monotonic()))
else:
    s.bind(("", PORT))
    for subject in words:
        s.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                     socket.inet_aton(group(int(subject, 0))) + socket.inet_aton(own))
    print("ready", flush=True)
    while True:
        datagram = s.recv(65536)
        print(f"0x{datagram[:8].hex()} {datagram[9:].hex()}", flush=True)
