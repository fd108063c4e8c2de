# SPDX-License-Identifier: BSD-2-Clause
"""A subscriber that is no gateway, on a bus or on UDP multicast, for guest tests. It needs nothing of MLCCA.
  subscriber.py can INTERFACE NODE ETAG   subscribes by frames of node NODE; ETAG is that of SUBSCRIB
  subscriber.py udp ADDRESS               by datagrams
Then reads commands: "subscribe SUBJECT NUMBER LEASE-S HOPS NAME=VALUE..." (attributes in ns or events),
"end SUBJECT NUMBER", "plain SUBJECT". Prints "granted NUMBER" and "refused NUMBER WHY" as they come."""
import os
import select
import socket
import struct
import sys

OWN = b"SUBSCRIB"
TAGS = {"Latency": 1, "Jitter": 2, "Deadline": 3, "Period": 4, "Bandwidth": 5, "PacketLoss": 6, "Omission": 7, "MaxPayload": 8}


def element(tag, content):
    return bytes([tag, len(content)]) + content


def integer(tag, value):
    return element(tag, value.to_bytes(value.bit_length() // 8 + 1, "big"))


def channel(subject, attributes):
    """A subscriber in the run-time representation (proto/mlcca.asn1)."""
    listed = b"".join(integer(0x80 | TAGS[name], attributes[name]) for name in sorted(attributes, key=TAGS.get))
    return element(0x30, integer(2, 1) + integer(10, 1) + element(4, subject) + element(0x30, listed))


def message(kind, number, lease, hops, rest):
    return OWN + bytes([1, kind]) + struct.pack(">IHB", number, lease, hops) + rest


class Can:
    def __init__(self, interface, node, etag):
        self.socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self.socket.bind((interface,))
        self.node, self.etag, self.begun = int(node, 0), int(etag, 0), {}

    def frame(self, fragment, data):
        can_id = 0x9F400000 | (fragment << 21) | self.node << 14 | self.etag
        self.socket.send(struct.pack("=IB3x8s", can_id, len(data), data))

    def send(self, event):
        if len(event) <= 8:
            return self.frame(0, event)
        parts = [event[i:i + 7] for i in range(0, len(event), 7)]
        for i, part in enumerate(parts):
            self.frame(1, bytes([(0x20 if i == 0 else 0) | len(parts) - 1 - i]) + part)

    def receive(self):
        can_id, length, data = struct.unpack("=IB3x8s", self.socket.recv(16))
        if can_id & 0x3FFF != self.etag:
            return None
        if not can_id & 1 << 21:
            return data[:length]
        source, left = can_id >> 14 & 0x7F, data[0] & 0x1F
        if data[0] & 0x20:
            self.begun[source] = b""
        self.begun[source] = self.begun.get(source, b"") + data[1:length]
        return self.begun.pop(source) if left == 0 else None


class Udp:
    PORT = 9999

    def __init__(self, address):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(("", self.PORT))
        self.group = f"239.{OWN[0]}.{OWN[7]}.{OWN[5]}"
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(address))
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 0)
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP,
                               socket.inet_aton(self.group) + socket.inet_aton(address))

    def send(self, event):
        self.socket.sendto(OWN + b"\0" + event, (self.group, self.PORT))

    def receive(self):
        data = self.socket.recv(65536)
        return data[9:] if data[:9] == OWN + b"\0" else None


def subject_of(text):
    return int(text, 0).to_bytes(8, "big")


def obey(network, words):
    if words[0] == "plain":
        network.send(subject_of(words[1]))
    elif words[0] == "end":
        network.send(message(2, int(words[2]), 0, 0, subject_of(words[1])))
    else:
        attributes = {name: int(value) for name, value in (word.split("=") for word in words[5:])}
        network.send(message(1, int(words[2]), int(words[3]), int(words[4]), channel(subject_of(words[1]), attributes)))


network = Can(*sys.argv[2:]) if sys.argv[1] == "can" else Udp(*sys.argv[2:])
print("ready", flush=True)
commands = b""
while True:
    ready, _, _ = select.select([sys.stdin, network.socket], [], [])
    if sys.stdin in ready:
        some = os.read(0, 4096)
        if not some:
            break
        commands += some
        while b"\n" in commands:
            line, commands = commands.split(b"\n", 1)
            obey(network, line.decode().split())
    if network.socket in ready:
        event = network.receive()
        if event is None or len(event) < 25 or event[:9] != OWN + b"\1":
            continue
        number = struct.unpack(">I", event[10:14])[0]
        if event[9] == 3:
            print(f"granted {number}", flush=True)
        elif event[9] == 4:
            print(f"refused {number} {event[25:].decode()}", flush=True)
