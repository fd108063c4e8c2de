# SPDX-License-Identifier: BSD-2-Clause
"""A subscriber that is no gateway, on a bus, UDP multicast or IEEE 802.15.4, for guest tests. It needs nothing of MLCCA.
  subscriber.py can INTERFACE NODE ETAG   subscribes by frames of node NODE; ETAG is that of SUBSCRIB
  subscriber.py udp ADDRESS               by datagrams
  subscriber.py wpan INTERFACE SHORT      by data frames of that short address
Then reads commands: "subscribe SUBJECT NUMBER LEASE-S HOPS NAME=VALUE..." (attributes in ns or events),
"end SUBJECT NUMBER", "plain SUBJECT", "refuse SUBJECT NUMBER WHY". Prints "granted NUMBER" and "refused NUMBER WHY" as
they come; of 802.15.4 also "asked NUMBER SUBJECT FROM" and "event SUBJECT TEXT", and it obeys "send SUBJECT TEXT"."""
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


class Wpan:
    """By a packet socket: the kernel has sockets of IEEE 802.15.4 in the first network namespace alone."""
    PAN, BROADCAST, HEADER = 0xBEEF, 0xFFFF, struct.Struct("<HBHHH")

    def __init__(self, interface, short):
        self.socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(0xF6))
        self.socket.bind((interface, 0xF6))
        self.short = int(short, 0)

    def publish(self, subject, event):
        self.socket.send(self.HEADER.pack(0x8841, 1, self.PAN, self.BROADCAST, self.short) + subject + event)

    def send(self, event):
        self.publish(OWN, event)

    def receive(self):
        data, where = self.socket.recvfrom(256)
        if where[2] == socket.PACKET_OUTGOING or len(data) < self.HEADER.size + 8:
            return None
        sender, payload = self.HEADER.unpack(data[:self.HEADER.size])[4], data[self.HEADER.size:]
        if payload[:8] != OWN:
            print("event", name_of(payload[:8]), payload[8:].decode("latin-1"), flush=True)
            return None
        event = payload[8:]
        if event[:10] == OWN + b"\1\1":
            content = event[17 + 2 + 6:]  # behind the outer element and two integers: the subject
            print("asked", struct.unpack(">I", event[10:14])[0], name_of(content[2:10]), f"{sender:#06x}", flush=True)
        return event


def name_of(subject):
    return subject.rstrip(b"\0").decode("latin-1")


def subject_of(text):
    return int(text, 0).to_bytes(8, "big")


def obey(network, words):
    if words[0] == "plain":
        network.send(subject_of(words[1]))
    elif words[0] == "send":
        network.publish(words[1].encode().ljust(8, b"\0"), words[2].encode())
    elif words[0] == "refuse":
        network.send(message(4, int(words[2]), 0, 0, subject_of(words[1]) + " ".join(words[3:]).encode()))
    elif words[0] == "end":
        network.send(message(2, int(words[2]), 0, 0, subject_of(words[1])))
    else:
        attributes = {name: int(value) for name, value in (word.split("=") for word in words[5:])}
        network.send(message(1, int(words[2]), int(words[3]), int(words[4]), channel(subject_of(words[1]), attributes)))


network = {"can": Can, "udp": Udp, "wpan": Wpan}[sys.argv[1]](*sys.argv[2:])
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
