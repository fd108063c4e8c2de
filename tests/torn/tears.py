# SPDX-License-Identifier: BSD-2-Clause
"""What can be torn away from a gateway, in two worlds: Ethernet on this kernel, CAN in the guest."""
import ctypes
import glob
import os
import random
import struct
import subprocess
import sys
import time

from harness import sh


CORRUPT = b"\xa5" * 9
HOG = """
import os, resource, sys, time
resource.setrlimit(resource.RLIMIT_RTTIME, (4000000, 4000000))
os.sched_setaffinity(0, [int(sys.argv[1])])
os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(50))
end = time.monotonic() + 2
while time.monotonic() < end: pass
"""


class Tear:
    """apply() takes something away; undo() puts it back, if it lasts. opens(daemon lives, interface): of which
    interfaces root has taken the gate away by that."""

    def __init__(self, apply, undo=None, opens=None, each_interface=False):
        self.apply = apply
        self.undo = undo
        self.lasts = undo is not None
        self.opens = opens or (lambda lives, interface: [])
        self.each_interface = each_interface


class World:
    """What both have in common: bpffs, state directory, processor, memory."""

    run = "/run/mlcca"
    state = "/run/mlcca-state"
    interfaces: list
    granted: dict  # flow: the interfaces that it crosses
    refused: dict

    def __init__(self):
        self.daemon = None  # set by who runs it
        self.hogs = []
        self.corrupt_at, self.before_corruption = 0, b""
        self.tears = {
            "pins": Tear(lambda _: self.remove_pins()),
            "one-pin": Tear(self.remove_one_pin),
            "bpffs": Tear(lambda _: sh(f"umount -l {self.run}/bpf"), lambda _: self.mount_bpffs()),
            "state-gone": Tear(lambda _: sh(f"rm -rf {self.state}/*", check=False)),
            "state-read-only": Tear(lambda _: sh(f"mount --bind {self.state} {self.state} && mount -o remount,bind,ro {self.state}"),
                                    lambda _: sh(f"umount -l {self.state}")),
            "state-full": Tear(lambda _: sh(f"cat /dev/zero >{self.state}/filler", check=False), lambda _: sh(f"rm -f {self.state}/filler")),
            "state-corrupt": Tear(lambda _: self.corrupt_state(), lambda _: self.put_bytes_back()),
            "memory": Tear(lambda _: self.limit_memory(), lambda _: self.unlimit_memory()),
            "reload": Tear(lambda _: self.ask("reload")),
            "down": Tear(lambda i: self.up_or_down(i, "down"), lambda i: self.up_or_down(i, "up"), each_interface=True),
            "rename": Tear(self.rename, lambda i: self.rename_back(i), each_interface=True),
            "away": Tear(self.send_away, self.fetch_back, opens=self.that_one, each_interface=True),
            "delete": Tear(self.delete, self.create, opens=self.that_one, each_interface=True),
            "recreate": Tear(lambda i: (self.delete(i), self.create(i)), opens=self.that_one, each_interface=True),
        }
        self.mount_bpffs()
        os.makedirs(self.state, exist_ok=True)
        sh(f"mount -t tmpfs -o size=2m tmpfs {self.state}")

    def names(self):
        return list(self.tears)

    def tear(self, name):
        return self.tears[name]

    @staticmethod
    def that_one(_, interface):
        return [interface]

    @staticmethod
    def exists(interface):
        return os.path.exists(f"/sys/class/net/{interface}")

    def settle(self):
        """The daemon checks once a second what was torn."""
        begin = time.monotonic()
        while time.monotonic() < begin + 1.5:
            self.ask("status")
            time.sleep(0.1)

    def ask(self, *words):
        if self.daemon.alive():
            self.daemon.ctl(*words, seconds=3)

    # --- pins and bpffs --------------------------------------------------------------------------------

    def mount_bpffs(self):
        os.makedirs(f"{self.run}/bpf", exist_ok=True)
        sh(f"mount -t bpf bpf {self.run}/bpf")

    def pins(self):
        return [path for path in glob.glob(f"{self.run}/bpf/v*/**", recursive=True) if os.path.isfile(path)]

    def remove_pins(self):
        for path in self.pins():
            os.unlink(path)

    def remove_one_pin(self, _):
        pins = self.pins()
        if pins:
            os.unlink(random.choice(pins))

    # --- state directory -------------------------------------------------------------------------------

    def corrupt_state(self):
        """A few bytes of the newest entries; put_bytes_back() is the copy that a person has."""
        path = f"{self.state}/journal"
        if not os.path.exists(path) or os.path.getsize(path) < 128:
            return
        try:
            with open(path, "r+b") as file:
                self.corrupt_at = file.seek(-17, os.SEEK_END)
                self.before_corruption = file.read(9)
                file.seek(self.corrupt_at)
                file.write(CORRUPT)
        except OSError:
            pass  # it is read-only already

    def put_bytes_back(self):
        path = f"{self.state}/journal"
        if not os.path.exists(path):
            return
        with open(path, "r+b") as file:
            file.seek(self.corrupt_at)
            if file.read(9) == CORRUPT:
                file.seek(self.corrupt_at)
                file.write(self.before_corruption)

    # --- processor and memory ---------------------------------------------------------------------------

    def hog(self):
        """Every processor, above all others, for two graces. It ends by itself: nothing else runs meanwhile that
        could end it, but the kernel, which kills it at twice the time (RLIMIT_RTTIME)."""
        for cpu in os.sched_getaffinity(0):
            self.hogs.append(subprocess.Popen([sys.executable, "-Sc", HOG, str(cpu)]))

    def end_hogs(self):
        for hog in self.hogs:
            hog.wait()
        self.hogs = []

    def limit_memory(self):
        """It can grow by 256 KiB and no more; then it is asked for something."""
        if not self.daemon.alive():
            return
        pid = self.daemon.process.pid
        with open(f"/proc/{pid}/statm", encoding="ascii") as file:
            size = int(file.read().split()[0]) * os.sysconf("SC_PAGESIZE")
        # The soft limit alone: to raise the hard one again takes a capability that root may lack.
        sh(f"prlimit --pid {pid} --as={size + (256 << 10)}:", check=False)
        for words in (("channels",), ("gate",), ("reload",), ("status",)):
            self.ask(*words)

    def unlimit_memory(self):
        if self.daemon.alive():
            sh(f"prlimit --pid {self.daemon.process.pid} --as=unlimited:", check=False)

    # --- interfaces -------------------------------------------------------------------------------------

    def up_or_down(self, interface, how):
        if self.exists(interface):
            sh(f"ip link set {interface} {how}")

    def rename(self, interface):
        if self.exists(interface):
            sh(f"ip link set {interface} down; ip link set {interface} name {interface}x && ip link set {interface}x up")

    def rename_back(self, interface):
        if self.exists(f"{interface}x"):
            sh(f"ip link set {interface}x down; ip link set {interface}x name {interface} && ip link set {interface} up")

    def delete(self, interface):
        if self.exists(interface):
            sh(f"ip link del {interface}")

    def create(self, interface):
        raise NotImplementedError

    def send_away(self, interface):
        if self.exists(interface):
            sh(f"ip link set {interface} netns elsewhere")

    def fetch_back(self, interface):
        sh(f"ip -n elsewhere link set {interface} netns {os.getpid()}", check=False)
        self.bring_up(interface)

    def bring_up(self, interface):
        raise NotImplementedError

    def describe(self):
        with open(f"{self.run}/log", encoding="utf-8", errors="replace") as log:
            return "".join(log.readlines()[-12:])


class Ethernet(World):
    """eth0 and eth1 lead to the namespaces far0 and far1 (10.0.0.0/24, 10.1.0.0/24)."""

    interfaces = ["eth0", "eth1"]

    def __init__(self):
        super().__init__()
        sh("ip netns add elsewhere")
        self.granted, self.refused = {}, {}
        for i, interface in enumerate(self.interfaces):
            sh(f"ip netns add far{i} && ip -n far{i} link set lo up")
            self.create(interface)
            self.granted |= {f"in{i}": {interface}, f"out{i}": {interface}}
            self.refused |= {f"{name}{i}": {interface} for name in ("refused-in", "refused-out", "unknown-in", "unknown-out")}
        self.tears["detach"] = Tear(self.detach, opens=self.that_one, each_interface=True)
        self.tears["xdp"] = Tear(lambda i: sh(f"ip link set dev {i} xdp off", check=False), each_interface=True)

    def flows(self):
        flows = []
        for i in range(len(self.interfaces)):
            inward, outward = (f"far{i}", f"10.{i}.0.255", "-"), ("-", f"10.{i}.0.255", f"far{i}")
            for base, name in ((0x1000, "in"), (0x3000, "refused-in"), (0x5000, "unknown-in")):
                flows.append((f"{name}{i}", "udp", *inward, f"{base + i:x}"))
            for base, name in ((0x2000, "out"), (0x4000, "refused-out"), (0x6000, "unknown-out")):
                flows.append((f"{name}{i}", "udp", *outward, f"{base + i:x}"))
        return flows

    def create(self, interface):
        i = interface[-1]
        if sh(f"ip -n far{i} link show far", check=False) == 0:
            return  # it is there, by another name or in another namespace
        sh(f"ip link add {interface} mtu 1500 type veth peer name far mtu 1500 netns far{i}")
        sh(f"ip -n far{i} addr add 10.{i}.0.2/24 brd + dev far && ip -n far{i} link set far up")
        self.bring_up(interface)

    def bring_up(self, interface):
        if self.exists(interface):
            sh(f"ip addr replace 10.{interface[-1]}.0.1/24 brd + dev {interface}; ip link set {interface} up")

    def rename_back(self, interface):
        super().rename_back(interface)
        self.bring_up(interface)

    def detach(self, interface):
        """The first program of TCX there is detached, as `bpftool net detach` of Linux 6.11 does it: which is ours."""
        if not self.exists(interface):
            return
        with open(f"/sys/class/net/{interface}/ifindex", encoding="ascii") as file:
            index = int(file.read())
        hook = random.choice((46, 47))  # BPF_TCX_INGRESS, BPF_TCX_EGRESS
        BPF_PROG_DETACH, BPF_F_BEFORE = 9, 8
        wanted = struct.pack("=6IQ", index, 0, hook, BPF_F_BEFORE, 0, 0, 0)
        libc = ctypes.CDLL(None, use_errno=True)
        if libc.syscall(321, BPF_PROG_DETACH, ctypes.create_string_buffer(wanted, len(wanted)), len(wanted)) != 0:
            raise OSError(ctypes.get_errno(), f"nothing to detach from {interface}")


class Can(World):
    """can0 leads to the namespace robot, can1 to second; can-gw carries everything between them (gateway.sh)."""

    interfaces = ["can0", "can1"]
    peers = {"can0": ("r0", "robot"), "can1": ("s0", "second")}
    ids = {"beat": "1F480064", "back": "1F484065", "strict": "1F480066", "strictback": "1F484067", "unknown": "1F480070"}

    def __init__(self):
        super().__init__()
        sh("ip netns add elsewhere")
        self.index = 3000
        both = set(self.interfaces)
        self.granted = {"beat": both, "back": both}
        self.refused = {"strict": both, "strictback": both, "unknown": both, "in0": {"can0"}, "in1": {"can1"},
                        "out0": {"can0"}, "out1": {"can1"}}
        self.tears["filters"] = Tear(self.remove_filters, opens=self.that_one, each_interface=True)
        self.tears["qdisc"] = Tear(lambda i: sh(f"tc qdisc del dev {i} clsact", check=False), opens=self.that_one, each_interface=True)
        self.tears["hog"] = Tear(lambda _: self.hog(), lambda _: self.end_hogs())
        self.tears["clock"] = Tear(self.step_clock)
        self.tears["cgroup"] = Tear(lambda _: self.limit_cgroup(), lambda _: self.unlimit_cgroup())

    def flows(self):
        forth, back = ("second", "s0", "robot"), ("robot", "r0", "second")
        ids = self.ids
        return [("beat", "can", *forth, ids["beat"]), ("strict", "can", *forth, ids["strict"]), ("unknown", "can", *forth, ids["unknown"]),
                ("back", "can", *back, ids["back"]), ("strictback", "can", *back, ids["strictback"]),
                ("in0", "can", "robot", "r0", "-", ids["strictback"]), ("in1", "can", "second", "s0", "-", ids["strict"]),
                ("out0", "can", "-", "can0", "robot", ids["beat"]), ("out1", "can", "-", "can1", "second", ids["back"])]

    def create(self, interface):
        peer, space = self.peers[interface]
        if sh(f"ip -n {space} link show {peer}", check=False) == 0:
            return  # it is there, by another name or in another namespace
        self.index += 2
        sh(f"ip link add {interface} index {self.index} type vxcan peer name {peer} index {self.index + 1}")
        sh(f"ip link set {peer} netns {space} && ip -n {space} link set {peer} up")
        self.bring_up(interface)

    def bring_up(self, interface):
        if self.exists(interface):
            sh(f"ip link set {interface} up")
        sh("cangw -F; cangw -A -s can0 -d can1 -e; cangw -A -s can1 -d can0 -e", check=False)

    def remove_filters(self, interface):
        sh(f"tc filter del dev {interface} {random.choice(('ingress', 'egress'))}", check=False)

    def step_clock(self, _):
        """The clock of the day goes by up to ten days to either side."""
        time.clock_settime(time.CLOCK_REALTIME, time.time() + random.uniform(-864000, 864000))

    def limit_cgroup(self):
        """Its memory is limited to what it has: what it asks for more ends it, or makes it wait."""
        if not self.daemon.alive():
            return
        group = "/sys/fs/cgroup/torn"
        os.makedirs(group, exist_ok=True)
        with open(f"/sys/fs/cgroup/torn/cgroup.procs", "w", encoding="ascii") as file:
            file.write(str(self.daemon.process.pid))
        with open(f"{group}/memory.max", "w", encoding="ascii") as file:
            file.write(str(1 << 20))
        self.ask("channels")
        self.ask("reload")

    def unlimit_cgroup(self):
        if os.path.exists("/sys/fs/cgroup/torn/memory.max"):
            with open("/sys/fs/cgroup/torn/memory.max", "w", encoding="ascii") as file:
                file.write("max")


Worlds = {"ethernet": Ethernet, "can": Can}
