# SPDX-License-Identifier: BSD-2-Clause
"""What the harnesses "kills" and "torn" have in common: a daemon that is started, killed and asked,
and numbered traffic. Times are CLOCK_MONOTONIC in ns."""
import json
import mmap
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time

BUILD = os.environ.get("BUILD", "build")
PATIENCE = 60  # s: for what takes milliseconds, on a machine that is busy and emulated


class Failure(Exception):
    """What was promised does not hold."""


def note(*words):
    print(f"[{time.monotonic():9.2f}]", *words, flush=True)


def sh(command, check=True):
    """A shell command; gives its exit status."""
    done = subprocess.run(command, shell=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if check and done.returncode != 0:
        raise RuntimeError(f"{command}: {done.stdout}")
    return done.returncode


class Traffic:
    """build/tests/traffic, see its usage()."""

    def __init__(self, pause_us, flows):
        words = [",".join(str(part) for part in flow) for flow in flows]
        self.process = subprocess.Popen([f"{BUILD}/tests/traffic", str(pause_us), *words],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, *words):
        self.process.stdin.write(" ".join(str(w) for w in words) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline().split()
        if not answer:
            raise RuntimeError("the traffic program has ended")
        return answer

    def passes(self, flow, seconds=PATIENCE):
        """A time such that whatever `flow`'s sender sent before it is decided; None if nothing arrives."""
        answer = self.ask("passes", flow, int(seconds * 1000))
        return int(answer[1]) if answer[0] == "yes" else None

    def stopped(self, flow, seconds):
        """A time such that of many frames that were sent after it none arrived; None: some did. A sender that does not
        send is a failure of the machine or of the harness, and shows nothing."""
        answer = self.ask("stopped", flow, int(seconds * 1000))
        if answer[0] == "unknown":
            raise Failure(f"{flow} has sent {answer[1]} frames in a minute, which shows nothing; "
                          f"the traffic program: {threads_of(self.process.pid)}")
        return int(answer[1]) if answer[0] == "yes" else None

    def lost(self, flow, begin, end=0):
        return Spell(self.ask("lost", flow, begin, end))

    def wrong(self, flow, begin, end=0):
        return Spell(self.ask("wrong", flow, begin, end))

    def counts(self, flow):
        return dict(zip(("sent", "refused", "arrived", "twice"), map(int, self.ask("counts", flow))))

    def drain(self, *flows):
        self.ask("drain", PATIENCE * 1000, *flows)


def threads_of(pid):
    """Where each thread of a process waits: its name, its call and where that is in the kernel."""
    found = []
    folder = f"/proc/{pid}/task"
    for thread in os.listdir(folder):
        for name in ("comm", "syscall", "stack"):
            with open(f"{folder}/{thread}/{name}", encoding="utf-8") as file:
                found.append(f"{thread} {name} {file.read().rstrip()}")
    return "\n".join(found)


class Spell:
    """Frames that should not be: how many, and when the first and the last was sent."""

    def __init__(self, words):
        self.count, self.first, self.last = (int(w) for w in (words + ["0", "0"])[:3])

    def __bool__(self):
        return self.count > 0

    def __str__(self):
        return f"{self.count} frames, sent from {self.first / 1e9:.3f} to {self.last / 1e9:.3f}"


class Trap:
    """tests/fault/nth_call.h: where the daemon is to be killed."""

    LAYOUT = "=26Q"
    CLASSES = 0x1ffff & ~(1 << 10)  # every call but those that allocate memory

    def __init__(self, path):
        with open(path, "wb") as file:
            file.write(bytes(struct.calcsize(self.LAYOUT)))
        self.path = path
        self.file = open(path, "r+b")
        self.memory = mmap.mmap(self.file.fileno(), struct.calcsize(self.LAYOUT))
        struct.pack_into("=Q", self.memory, 56, self.CLASSES)

    def forget_process(self):
        self.memory[0:8] = bytes(8)

    def kill_at(self, call, after_us=0):
        pid = self.memory[0:8]
        self.memory[8:16] = bytes(8)  # counting, while the rest changes
        struct.pack_into("=3Q", self.memory, 16, call, 0, after_us)
        self.memory[40:48] = bytes(8)
        self.memory[0:8] = pid
        self.memory[8:16] = struct.pack("=Q", 1 if call else 0)

    def count(self):
        self.kill_at(0)

    def calls(self):
        return struct.unpack_from("=Q", self.memory, 40)[0]


class Daemon:
    """mlccad, which reports when it is ready, in the place of systemd."""

    def __init__(self, description, run, state, grace, trap=None, log="/dev/null"):
        self.description, self.run, self.state, self.grace, self.trap = description, run, state, grace, trap
        self.log = log
        self.socket = f"{run}/control.sock"
        self.process = None
        self.env = dict(os.environ, MLCCA_SOCKET=self.socket)
        notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        notify.bind(f"{run}/notify")
        self.ready = 0  # the process that has said it last
        threading.Thread(target=self.listen, args=(notify,), daemon=True).start()
        self.started = 0

    def spawn(self):
        env = dict(self.env, NOTIFY_SOCKET=f"{self.run}/notify")
        if self.trap:
            self.trap.forget_process()
            env |= {"LD_PRELOAD": os.path.abspath(f"{BUILD}/tests/nth_call.so"), "NTH_CALL": self.trap.path}
        with open(self.log, "ab") as log:
            self.process = subprocess.Popen(
                [f"{BUILD}/mlccad", "--description", self.description, "--socket", self.socket, "--bpf-root", f"{self.run}/bpf",
                 "--state-directory", self.state, "--grace", self.grace],
                stdout=log, stderr=log, stdin=subprocess.DEVNULL, env=env)
        self.started += 1

    def listen(self, notify):
        """Reads all that any daemon reports: sd_notify(3) waits where no process does."""
        notify.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)
        while True:
            text, control, _, _ = notify.recvmsg(4096, socket.CMSG_SPACE(12))
            if b"READY=1" in text and control:
                self.ready = struct.unpack("=3i", control[0][2])[0]

    def wait_ready(self, seconds=PATIENCE):
        """True once it is ready, False if it has ended before; a daemon that does neither is a failure."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if self.ready == self.process.pid:
                return True
            if self.process.poll() is not None:
                return False
            time.sleep(0.002)
        self.show_where()
        raise Failure(f"a start takes longer than {seconds} s")

    def show_where(self):
        """Where each thread of the daemon waits."""
        note(threads_of(self.process.pid))
        subprocess.run(["timeout", "60", "gdb", "-p", str(self.process.pid), "-batch", "-ex", "thread apply all bt"],
                       check=False)  # where there is one

    def start(self):
        self.spawn()
        return self.wait_ready()

    def alive(self):
        return self.process is not None and self.process.poll() is None

    def kill(self):
        if self.alive():
            self.process.send_signal(signal.SIGKILL)
        self.reap()

    def reap(self):
        """Its exit status; it must end by itself soon."""
        try:
            return self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired as late:
            raise Failure("the daemon does not end") from late

    def ctl(self, *words, seconds=PATIENCE):
        """mlccactl: exit status and output."""
        try:
            done = subprocess.run([f"{BUILD}/mlccactl", "--timeout", str(seconds), *words], env=self.env, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True, timeout=seconds + 5, check=False)
        except subprocess.TimeoutExpired:
            return 124, f"no answer in {seconds} s"
        return done.returncode, done.stdout

    def json(self, *words):
        status, text = self.ctl("--json", *words)
        if status != 0:
            raise Failure(f"mlccactl {' '.join(words)}: status {status}: {text}")
        return json.loads(text)

    def verify(self, *words):
        return self.ctl("gate", "--verify", "--bpf-root", f"{self.run}/bpf", "--state-directory", self.state, *words)


def main(harness):
    """Runs it; a failure is printed in one line, and is the exit status."""
    try:
        harness()
    except Failure as failure:
        note("FAILED:", failure)
        sys.exit(1)
