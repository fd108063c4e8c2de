# SPDX-License-Identifier: BSD-2-Clause
"""Real gateways and a real store of three members, each in a network namespace, and what can go wrong with them."""
import ctypes
import glob
import os
import signal
import subprocess
import threading

from delay import Delay

BUILD = os.path.abspath(os.environ.get("BUILD", "build"))
WORK = "/run/work"
MEMBERS = ("m0", "m1", "m2")
LEASE = 2  # s
PERIOD_MS = 40
# Media, and the bytes per s that each carries. All gateways are on lan. gw1 and gw2 join lan and side next to each other.
# Each gateway has a cell of its own.
CAPACITY = {"lan": 1100, "side": 800}
# What the description promises, by its subject: c0 of gw1 on lan, f0 from lan to side.
C0, F0 = 1, 2
C0_BYTES, F0_BYTES = 200, 100
DESCRIBED = {"lan": C0_BYTES + F0_BYTES, "side": F0_BYTES}
PARALLEL = ROLLS_OUT = ("gw1", "gw2")
FAKETIME = next(glob.iglob("/usr/lib/*/faketime/libfaketime.so.1"), "libfaketime.so.1")
CHANNELS = ((1, 8), (2, 16), (3, 24), (4, 8))  # number, payload: 200, 400, 600 and 200 bytes per s
ACROSS = 4  # the number of the one that leads over lan and the next gateway into the cell of that one
LOCK = threading.Lock()  # processes are started one at a time, so that none inherits what is another's


def sh(command, check=True):
    """A shell command; gives what it says, None if it failed."""
    done = subprocess.run(command, shell=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                          cwd=WORK)
    if done.returncode == 0:
        return done.stdout
    if check:
        raise RuntimeError(f"{command}: {done.stdout}")
    return None


def channel_name(gateway, number):
    return f"g{gateway}c{number}"


def subject_of(gateway, number):
    return (gateway << 8) | number


def next_of(gateway, gateways):
    """The number of the gateway that carries the channel ACROSS of this one further."""
    return gateway % gateways + 1


def ports_of(name):
    """Networks of a gateway. Its interface is NETWORK0, and the observer has the other end of the pair."""
    return ("lan", "side", "cell") if name in PARALLEL else ("lan", "cell")


def observed(network, name):
    return f"{network}-{name}"


def address_of(place):
    """In the network of the store: 10.9.0.10 to .12 of members, .21 and up of gateways."""
    return f"10.9.0.{10 + int(place[1:]) if place[0] == 'm' else 20 + int(place[2:])}"


def inside(namespace, make):
    """Calls `make` in a namespace: sockets stay where they were made."""
    libc = ctypes.CDLL(None, use_errno=True)
    with open("/proc/thread-self/ns/net", encoding="ascii") as home, \
            open(f"/run/netns/{namespace}", encoding="ascii") as there:
        if libc.setns(there.fileno(), 0) != 0:
            raise OSError(ctypes.get_errno(), "setns")
        try:
            return make()
        finally:
            libc.setns(home.fileno(), 0)


def remove_links():
    """Those of a World, and its namespaces. The kernel removes what is in a namespace some time after the namespace."""
    sh("for l in $(ls /sys/class/net); do case $l in [sd]-*|lan-*|side-*|cell-*|store) ip link del $l ;; esac; done")
    sh("for n in $(ip netns list | cut -d' ' -f1); do ip netns del $n; done")


class Process:
    """Of a namespace. What it says goes to a log."""

    def __init__(self, namespace, command, log, env=None):
        self.command = ["ip", "netns", "exec", namespace, *command]
        self.log, self.env, self.process = f"{WORK}/{log}", env, None

    def start(self):
        with LOCK, open(self.log, "ab") as log:
            self.process = subprocess.Popen(self.command, stdout=log, stderr=log, stdin=subprocess.DEVNULL, cwd=WORK,
                                            env=dict(os.environ, **(self.env or {})))

    def alive(self):
        return self.process is not None and self.process.poll() is None

    def signal(self, number):
        if self.alive():
            self.process.send_signal(number)

    def kill(self):
        self.signal(signal.SIGKILL)
        self.process.wait()


def certificates(users):
    """As docs/how-to/cluster-etcd.md has them. The user tick has a password: its way of JSON refuses common names."""
    names = ",".join(["IP:127.0.0.1"] + [f"IP:{address_of(member)}" for member in MEMBERS])
    sh(f"""set -e
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=authority -keyout ca.key -out ca.pem
certificate() {{ # NAME USES SUBJECT
	openssl req -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj $3 -keyout $1.key -out $1.csr
	printf 'subjectAltName={names}\\nextendedKeyUsage=%s\\n' $2 >$1.ext
	openssl x509 -req -in $1.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile $1.ext -out $1.pem
}}
certificate server serverAuth,clientAuth /CN=server
certificate tick clientAuth /O=tick
for user in {" ".join(users)}; do certificate $user clientAuth /CN=$user; done""")


def description(gateways, comment=""):
    """Of all media. The channels of CHANNELS are for who comes later: c0 and f0 are described. What passes a gateway is
    sent on by a program of root. With another comment it is another description, with another digest."""
    def attributes(period, octets):
        return f"<Attributes period='{period}ms' maxPayload='{octets}'/>"

    def network(name, bandwidth):
        return (f"<Network name='{name}'><Kind>udp-multicast</Kind><Profile>famouso</Profile>"
                f"<Provision latency='1ms' period='1ms' maxPayload='64' omission='0' bandwidth='{bandwidth}B/s'/></Network>")

    def port(gateway, name):
        here = f"cell{gateway}" if name == "cell" else name
        return f"<Port network='{here}' sender='root'><Interface name='{name}0'/></Port>"

    def channel(name, subject, inside=""):
        return f"<EventChannel name='{name}'><SubjectUID>{subject:#x}</SubjectUID>{inside}</EventChannel>"

    numbers = range(1, gateways + 1)
    lines = ["<System name='t'>", f"<!-- {comment} -->",
             channel("c0", C0, attributes(PERIOD_MS, C0_BYTES * PERIOD_MS // 1000)),
             channel("f0", F0, attributes(PERIOD_MS, F0_BYTES * PERIOD_MS // 1000))]
    lines += [channel(channel_name(n, number), subject_of(n, number)) for n in numbers for number, _ in CHANNELS]
    lines += [network(name, capacity) for name, capacity in CAPACITY.items()]
    lines += [network(f"cell{n}", 1000) for n in numbers]
    for n in numbers:
        lines.append(f"<Gateway name='gw{n}'><Provision latency='1ms' omission='0'/>"
                     + "".join(port(n, name) for name in ports_of(f"gw{n}")) + "</Gateway>")
    lines += ["<Publisher channel='c0' gateway='gw1' user='root'/><Subscriber channel='c0' network='lan'/>",
              "<Publisher channel='f0' network='lan'/><Subscriber channel='f0' network='side'/>", "</System>"]
    return "\n".join(lines)


class World:
    def __init__(self, gateways):
        self.gateways = [f"gw{n}" for n in range(1, gateways + 1)]
        self.cuts = set()
        self.links()
        certificates(["root", *self.gateways])
        self.write_description("system.xml", "")
        cluster = ",".join(f"{member}=http://{address_of(member)}:2380" for member in MEMBERS)
        self.members = {member: self.member(member, cluster) for member in MEMBERS}
        for member in self.members.values():
            member.start()
        self.roles()
        self.bridges = {name: self.bridge(name) for name in self.gateways}
        self.daemons = {name: self.daemon(name) for name in self.gateways}

    def write_description(self, name, comment):
        with open(f"{WORK}/{name}", "w", encoding="utf-8") as file:
            file.write(description(len(self.gateways), comment))

    def links(self):
        """The store has a network of its own, with a second way for frames that are to be late. Of lan, of side and of its
        cell each gateway has one end, and the observer the other one."""
        sh("ip link add store type bridge && ip link set store up")
        for place in (*MEMBERS, *self.gateways):
            sh(f"""set -e
ip netns add {place}
ip -n {place} link set lo up
ip link add st0 netns {place} type veth peer name s-{place}
ip link set s-{place} master store up
ip link add d-{place} type veth peer name b-{place}
ip link set d-{place} up
ip link set b-{place} up
ip -n {place} addr add {address_of(place)}/24 dev st0
ip -n {place} link set st0 up
ip netns exec {place} nft -f - <<'END'
table inet faults {{
	set from {{ type ipv4_addr; }}
	chain in {{ type filter hook input priority 0; ip saddr @from drop; }}
}}
END""")
        for name in self.gateways:
            sh(f"""set -e
mkdir -p {name}.bpf {name}.state
mount -t bpf bpf {name}.bpf""")
            for part, network in enumerate(ports_of(name)):
                sh(f"""set -e
ip link add {network}0 netns {name} type veth peer name {observed(network, name)}
ip link set {observed(network, name)} up
ip -n {name} addr add 10.{6 + part}.0.{name[2:]}/24 dev {network}0
ip -n {name} link set {network}0 up
ip -n {name} route add 239.0.0.0/8 dev {network}0 metric {part + 1}""")

    def member(self, name, cluster):
        peer, client = f"http://{address_of(name)}:2380", f"https://{address_of(name)}:2379"
        return Process(name, [
            "etcd", "--name", name, "--data-dir", f"{WORK}/{name}.data", "--listen-client-urls",
            f"{client},https://127.0.0.1:2379", "--advertise-client-urls", client, "--listen-peer-urls", peer,
            "--initial-advertise-peer-urls", peer, "--initial-cluster", cluster, "--cert-file", "server.pem", "--key-file",
            "server.key", "--client-cert-auth", "--trusted-ca-file", "ca.pem", "--bcrypt-cost", "4", "--logger", "zap",
            "--log-level", "error"], f"{name}.log")

    def control(self, command, member=MEMBERS[0], check=True):
        """etcdctl of root, at one member."""
        return sh(f"ETCDCTL_API=3 ip netns exec {member} etcdctl --cacert=ca.pem --cert=root.pem --key=root.key "
                  f"--dial-timeout=20s --command-timeout=20s --endpoints=https://127.0.0.1:2379 {command}", check)

    def roles(self):
        """As docs/how-to/cluster-etcd.md has them."""
        steps = ["user add root --no-password", "user grant-role root root", "role add tick",
                 "role grant-permission tick --prefix=true readwrite /tick/", "user add tick:tick", "user grant-role tick tick"]
        for name in self.gateways:
            grant = f"role grant-permission {name}"
            steps += [f"role add {name}", f"{grant} --prefix=true read /mlcca/t/", f"{grant} readwrite /mlcca/t/m/{name}",
                      f"{grant} readwrite /mlcca/t/d/vote/{name}"]
            prefixes = [f"x/{name}/", f"a/{name}/", "f/", "v/"]
            prefixes += [f"r/{network}/{name}/" for network in ports_of(name) if network in CAPACITY]
            steps += [f"{grant} --prefix=true readwrite /mlcca/t/{prefix}"
                      for prefix in prefixes + (["d/"] if name in ROLLS_OUT else [])]
            steps += [f"user add {name} --no-password", f"user grant-role {name} {name}"]
        steps.append("auth enable")
        ready = "until etcdctl endpoint health; do sleep 0.1; done"
        script = "set -e\n" + "\n".join(["etcdctl() { command etcdctl --cacert=ca.pem --cert=root.pem --key=root.key "
                                         "--dial-timeout=20s --command-timeout=20s --endpoints=https://127.0.0.1:2379 \"$@\"; }",
                                         ready] + [f"etcdctl {step}" for step in steps])
        with open(f"{WORK}/roles", "w", encoding="utf-8") as file:
            file.write(script)
        sh("ETCDCTL_API=3 ip netns exec m0 sh roles")

    def bridge(self, name):
        with open(f"{WORK}/{name}.conf", "w", encoding="utf-8") as file:
            for member in MEMBERS:
                file.write(f"endpoint = https://{address_of(member)}:2379\n")
            file.write(f"ca = {WORK}/ca.pem\ncertificate = {WORK}/{name}.pem\nkey = {WORK}/{name}.key\n")
        return Process(name, [f"{BUILD}/mlcca-cluster", "--settings", f"{WORK}/{name}.conf", "--socket",
                              f"{WORK}/{name}.cluster"], f"{name}.bridge.log")

    def daemon(self, name):
        return Process(name, [
            f"{BUILD}/mlccad", "--description", f"{WORK}/system.xml", "--gateway", name, "--socket", f"{WORK}/{name}.sock",
            "--bpf-root", f"{WORK}/{name}.bpf", "--state-directory", f"{WORK}/{name}.state", "--cluster-settings",
            f"{WORK}/{name}.conf", "--cluster-socket", f"{WORK}/{name}.cluster", "--lease", f"{LEASE}s"], f"{name}.log",
            self.clock(name))

    def clock(self, name):
        """The environment of a program whose clock is set by set_clock(), within a second. Only CLOCK_REALTIME can be set,
        as on any machine."""
        self.set_clock(name, 0)
        return {"LD_PRELOAD": FAKETIME, "FAKETIME_TIMESTAMP_FILE": f"{WORK}/{name}.clock", "FAKETIME_CACHE_DURATION": "1",
                "FAKETIME_DONT_FAKE_MONOTONIC": "1"}

    @staticmethod
    def set_clock(name, seconds):
        """How far it is ahead of that of the machine."""
        with open(f"{WORK}/{name}.clock.new", "w", encoding="ascii") as file:
            file.write(f"{seconds:+d}\n")
        os.rename(f"{WORK}/{name}.clock.new", f"{WORK}/{name}.clock")

    def start(self):
        for name in self.gateways:
            self.bridges[name].start()
            self.daemons[name].start()

    def ask(self, name, *words, patience=8):
        """mlccactl: its exit status, and what it says. `patience` in s."""
        with LOCK:
            process = subprocess.Popen([f"{BUILD}/mlccactl", "--socket", f"{WORK}/{name}.sock", "--timeout", str(patience), *words],
                                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        said, _ = process.communicate()
        return process.returncode, said

    # What can be between two sides.

    def cut(self, here, there):
        """Nothing from `there` arrives `here` any more."""
        sh(f"ip netns exec {here} nft add element inet faults from '{{ {address_of(there)} }}'")
        self.cuts.add((here, there))

    def mend_cuts(self):
        for here, there in self.cuts:
            sh(f"ip netns exec {here} nft delete element inet faults from '{{ {address_of(there)} }}'")
        self.cuts.clear()

    @staticmethod
    def delay(place, milliseconds):
        """All that is sent to it, or by it, from now on; end() of what it gives is the end."""
        return Delay(place, milliseconds / 1000, sh)
