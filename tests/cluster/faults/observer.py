# SPDX-License-Identifier: BSD-2-Clause
"""What can be seen from outside: the history of the store, and the frames on the medium. Times are CLOCK_REALTIME in s.

When a revision was committed is known by two bounds. `seen` is when it arrived at the first of three watches, one of each
member: not before the commit. `after` is when the latest of the observer's own entries was sent that has a smaller
revision: not after the commit. Whoever judges takes the bound that excuses more."""
import base64
import http.client
import json
import os
import select
import socket
import ssl
import struct
import subprocess
import threading
import time

from world import (ACROSS, C0, C0_BYTES, CHANNELS, F0, F0_BYTES, LOCK, MEMBERS, PARALLEL, PERIOD_MS, WORK, inside, next_of,
                   observed, ports_of, subject_of)

SO_TIMESTAMPNS = 35
ETH_P_IP = 0x800
EVENT_PORT = 9999
TICK = 0.2  # s


class Revision:
    def __init__(self, number, seen, events):
        self.number, self.seen, self.events = number, seen, events
        self.after = 0.0


class History:
    """Of the store, by three watches."""

    def __init__(self):
        self.revisions = {}
        self.lock = threading.Lock()
        self.ends = False
        self.watches = {}
        for member in MEMBERS:
            threading.Thread(target=self.watch, args=(member,), daemon=True).start()

    def watch(self, member):
        latest = 0
        while not self.ends:
            with LOCK:
                self.watches[member] = subprocess.Popen(
                    ["ip", "netns", "exec", member, "etcdctl", "--cacert=ca.pem", "--cert=root.pem", "--key=root.key",
                     "--endpoints=https://127.0.0.1:2379", "watch", "--prefix", "/", f"--rev={latest + 1}", "-w", "json"],
                    stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL, cwd=WORK,
                    env=dict(os.environ, ETCDCTL_API="3"))
            for line in self.watches[member].stdout:
                seen = time.time()
                said = json.loads(line)
                latest = max(latest, self.take(said, seen))
                if said.get("Canceled"):
                    self.watches[member].kill()
            self.watches[member].wait()
            time.sleep(0.2)

    def take(self, said, seen):
        by_revision = {}
        for event in said.get("Events") or []:
            kv = event["kv"]
            value = None if event.get("type") == 1 else base64.b64decode(kv.get("value", ""))
            by_revision.setdefault(kv["mod_revision"], []).append((base64.b64decode(kv["key"]).decode(), value))
        with self.lock:
            for number, events in by_revision.items():
                if number not in self.revisions:
                    self.revisions[number] = Revision(number, seen, events)
                self.revisions[number].seen = min(self.revisions[number].seen, seen)
        # What was compacted meanwhile another watch has.
        return max(max(by_revision, default=0), said.get("CompactRevision", 0) - 1)

    def latest(self):
        with self.lock:
            return max(self.revisions, default=0)

    def end(self, revision):
        """Everything up to that revision, in order. Whatever is missing is an error of the observer."""
        patience = time.monotonic() + 60
        while revision not in self.revisions or len(self.revisions) < revision - 1:
            if time.monotonic() > patience:
                raise RuntimeError(f"the watches have {len(self.revisions)} of {revision - 1} revisions")
            time.sleep(0.05)
        self.ends = True
        after = 0.0
        out = []
        for number in range(2, revision + 1):
            one = self.revisions[number]
            one.after = after
            for key, value in one.events:
                if key.startswith("/tick/"):
                    after = max(after, float(value))
            out.append(one)
        return out


class Ticks:
    """The observer's own entries in the store: when each was sent."""

    def __init__(self):
        self.ends = False
        self.count, self.problem = 0, ""
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    @staticmethod
    def connect(member):
        context = ssl.create_default_context(cafile=f"{WORK}/ca.pem")
        context.load_cert_chain(f"{WORK}/tick.pem", f"{WORK}/tick.key")
        connection = http.client.HTTPSConnection("127.0.0.1", 2379, context=context, timeout=1)
        inside(member, connection.connect)
        return connection

    @staticmethod
    def post(connection, path, body, token=None):
        connection.request("POST", path, json.dumps(body), {"Authorization": token} if token else {})
        said = connection.getresponse().read().decode()
        if not said.startswith("{"):
            raise OSError(said)
        answer = json.loads(said)
        if "error" in answer:
            raise OSError(answer["error"])
        return answer

    def run(self):
        turn = 0
        while not self.ends:
            connection = None
            try:
                connection = self.connect(MEMBERS[turn % len(MEMBERS)])
                token = self.post(connection, "/v3/auth/authenticate", {"name": "tick", "password": "tick"})["token"]
                while not self.ends:
                    encode = lambda text: base64.b64encode(text.encode()).decode()
                    self.post(connection, "/v3/kv/put",
                              {"key": encode(f"/tick/{turn % len(MEMBERS)}"), "value": encode(repr(time.time()))}, token)
                    self.count += 1
                    time.sleep(TICK)
            except (OSError, ValueError, KeyError, http.client.HTTPException) as failed:
                self.problem = repr(failed)
                time.sleep(TICK)
            if connection is not None:
                connection.close()
            turn += 1


class Wire:
    """Frames that have passed the gates: by gateway, network and subject, when. The time is that of the kernel."""

    def __init__(self, gateways):
        self.frames = {}
        self.ends = False
        self.sockets = {}
        for name, network in ((name, network) for name in gateways for network in ports_of(name)):
            one = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_IP))
            one.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
            one.bind((observed(network, name), ETH_P_IP))
            self.sockets[one] = (int(name[2:]), network)
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        while not self.ends:
            for one in select.select(list(self.sockets), [], [], 0.2)[0]:
                frame, control, _, address = one.recvmsg(2048, 64)
                if address[2] != socket.PACKET_OUTGOING and frame[23] == 17:
                    self.take(self.sockets[one], frame, control)

    def take(self, place, frame, control):
        udp = 14 + (frame[14] & 15) * 4
        if struct.unpack_from("!H", frame, udp + 2)[0] != EVENT_PORT:
            return
        seconds, nanoseconds = struct.unpack("=qq", control[0][2][:16])
        subject = struct.unpack_from("!Q", frame, udp + 8)[0]
        self.frames.setdefault((*place, subject), []).append(seconds + nanoseconds / 1e9)

    def at(self, gateway, network, subject):
        return self.frames.get((gateway, network, subject), [])

    def count(self, gateway, network, subject):
        return len(self.at(gateway, network, subject))

    def on_media(self, gateway, subject):
        """On all that gateways share, in order."""
        return sorted(self.at(gateway, "lan", subject) + self.at(gateway, "side", subject))

    def end(self):
        self.ends = True
        self.thread.join()
        return sum(struct.unpack("=II", one.getsockopt(263, 6, 8))[1] for one in self.sockets)


class Traffic:
    """Programs on all gateways send whatever is granted to them, and whatever is not: of their own channels, and of those
    that they carry further."""

    def __init__(self, gateways):
        self.ends = False
        self.flows = []
        payloads = dict(CHANNELS)
        for name in gateways:
            gateway = int(name[2:])
            before = next(n for n in range(1, len(gateways) + 1) if next_of(n, len(gateways)) == gateway)
            flows = {"lan": [(subject_of(gateway, number), octets) for number, octets in CHANNELS], "side": [],
                     "cell": [(subject_of(before, ACROSS), payloads[ACROSS])]}
            if gateway == 1:
                flows["lan"].append((C0, C0_BYTES * PERIOD_MS // 1000))
            if name in PARALLEL:  # a route of its own may lead over either
                flows["side"] += [(F0, F0_BYTES * PERIOD_MS // 1000), flows["lan"][ACROSS - 1]]
            for network in ports_of(name):
                self.flow(name, network, flows[network])
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def flow(self, name, network, subjects):
        to = inside(name, lambda: socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        to.setsockopt(socket.SOL_SOCKET, socket.SO_BINDTODEVICE, f"{network}0".encode())
        to.setblocking(False)
        for subject, octets in subjects:
            self.flows.append((to, struct.pack("!QB", subject, 0) + bytes(octets), f"239.0.{subject & 0xff}.1"))

    def run(self):
        due = time.monotonic()
        while not self.ends:
            for to, datagram, group in self.flows:
                try:
                    to.sendto(datagram, (group, EVENT_PORT))
                except OSError:
                    pass  # a gate has dropped it
            due = max(due + PERIOD_MS / 1000, time.monotonic() - 1)
            time.sleep(max(0.0, due - time.monotonic()))

    def end(self):
        self.ends = True
        self.thread.join()
