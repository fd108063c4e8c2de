# SPDX-License-Identifier: BSD-2-Clause
"""Machines of a test: each has a network namespace, its own /etc, /var/lib and /run/mlcca, and one bash."""
import os
import pathlib
import pty
import shlex
import subprocess

HERE = pathlib.Path(__file__).resolve().parent
BUILD = os.path.abspath(os.environ.get("BUILD", "build"))
WORK = pathlib.Path("/run/work")
END = "=== end "
BRIDGE = "store"  # it joins eth0 of all machines

SETUP = """set -e
mkdir etc && cp -a /etc/. etc && mount --bind etc /etc
for name in mlcca etcd; do
    grep -q "^$name:" /etc/group || groupadd --system "$name"
    grep -q "^$name:" /etc/passwd || useradd --system --no-create-home -g "$name" "$name"
done
mkdir -p /etc/mlcca /etc/etcd /run/mlcca
mount -t tmpfs tmpfs /var/lib && mkdir /var/lib/mlcca /var/lib/etcd
mount -t tmpfs tmpfs /run/mlcca && mkdir /run/mlcca/bpf && mount -t bpf bpf /run/mlcca/bpf
hostname "$NAME"
ip link set lo up
set +e -E
failed() { _failed=$1; echo "[status $1] $2"; }
"""


class Failure(Exception):
    """A command did something else than its page says."""


class Machine:
    def __init__(self, name, address, ports=()):
        self.name, self.folder = name, WORK / name
        (self.folder / "bin").mkdir(parents=True)
        (self.folder / "bin/systemctl").symlink_to(HERE / "systemctl")
        (self.folder / "bin/sudo").write_text('#!/bin/sh\nexec "$@"\n')
        (self.folder / "bin/sudo").chmod(0o755)
        self.person, self.terminal = pty.openpty()
        environment = dict(os.environ, NO_COLOR="1", LC_ALL="C.UTF-8", BUILD=BUILD, MACHINE=str(self.folder), NAME=name,
                           PATH=f"{self.folder}/bin:{BUILD}:{os.environ['PATH']}", ETCDCTL_COMMAND_TIMEOUT="60s",
                           ETCDCTL_DIAL_TIMEOUT="60s")
        self.bash = subprocess.Popen(["unshare", "--mount", "--net", "--uts", "--propagation", "private", "bash", "--norc"],
                                     cwd=self.folder, env=environment, text=True, errors="replace", stdin=subprocess.PIPE,
                                     stdout=subprocess.PIPE, stderr=subprocess.STDOUT, pass_fds=(self.terminal,))
        self.do(SETUP, check=False)
        self.cable("eth0", f"{address}/24", f"master {BRIDGE}")
        for number, port in enumerate(ports, 1):
            self.cable(port, f"10.{number}.0.{address.rpartition('.')[2]}/24")

    def cable(self, interface, address, more=""):
        """An interface, whose other end is outside of the machine."""
        end = f"{interface}-{self.name}"
        subprocess.run(f"ip link add {interface} netns {self.bash.pid} type veth peer name {end} && "
                       f"ip link set {end} {more} up", shell=True, check=True)
        self.do(f"ip addr add {address} dev {interface} && ip link set {interface} up")

    def give(self, text):
        self.bash.stdin.write(text)
        self.bash.stdin.flush()

    def start(self, text, name="command", answer=None):
        """Gives bash a text, which is one step of its session."""
        (self.folder / f"{name}.sh").write_text(text + "\n", encoding="utf-8")
        if answer is not None:
            os.write(self.person, answer.encode())
        self.give(f"_failed=0; trap 'failed $? \"$BASH_COMMAND\"' ERR; . ./{shlex.quote(name)}.sh <&{self.terminal}; "
                  f"trap - ERR; echo; echo '{END}'$_failed\n")

    def end(self, check=True):
        """What the step has printed. A command that fails, and is not told to, is an error."""
        printed = ""
        for line in self.bash.stdout:
            if line.startswith(END):
                if check and int(line[len(END):]) != 0:
                    raise Failure(f"{self.name}:\n{printed}")
                return printed.rstrip("\n") + "\n"
            printed += line
        raise Failure(f"{self.name}: bash has ended:\n{printed}")

    def do(self, text, check=True):
        self.start(text)
        return self.end(check)

    def put(self, name, text):
        """A file of the machine, by its absolute path or in the folder where commands run."""
        self.do(f"cat > {name} <<'END_OF_FILE'\n{text}\nEND_OF_FILE")

    def logs(self):
        return "".join(f"--- {self.name}: {log.name}\n" + "".join(log.open(encoding="utf-8").readlines()[-15:])
                       for log in sorted(self.folder.glob("*.log")))
