# SPDX-License-Identifier: BSD-2-Clause
# For cases with two gateways between the same two Ethernets, lan and field, in namespaces "first" and
# "second": networks, the part of the description that all have, daemons and relays, a source and a sink.
. "$(dirname "${BASH_SOURCE[0]}")/gateway.sh"
modprobe -a veth bridge sch_netem
user=990
echo "mlcca-relay:x:$user:$user::/:/usr/sbin/nologin" >>/etc/passwd

# lan: source, first, second; field: first, second, sink. A bridge each, which floods groups. A datagram is
# one packet there: of IP fragments that come before the first one, the gate drops all.
segment() { # segment BRIDGE NUMBER NAMESPACE=INTERFACE...: 10.NUMBER.0.I
	local i=1 end
	ip link add "$1" mtu 9000 type bridge mcast_snooping 0
	ip link set "$1" up
	for end in "${@:3}"; do
		ip netns add "${end%=*}" 2>/dev/null
		ip link add "$1-$i" mtu 9000 master "$1" up type veth peer name "${end#*=}" mtu 9000 netns "${end%=*}"
		in_ns "${end%=*}" ip addr add "10.$2.0.$i/24" dev "${end#*=}"
		in_ns "${end%=*}" ip link set "${end#*=}" up
		in_ns "${end%=*}" ip link set lo up
		i=$((i + 1))
	done
}
segment lan 1 source=out first=eth1 second=eth1
segment field 2 sink=in first=eth2 second=eth2

ether() { # ether NAME [ELEMENTS]
	echo "<Network name='$1'><Kind>udp-multicast</Kind><Profile>famouso</Profile><Provision>"
	value Latency 1 ms
	value Period 1 ms
	value Omission 0
	value MaxPayload 65535 bytes
	echo "</Provision>$2</Network>"
}
side_by_side() { # side_by_side [ATTRIBUTES of a Gateway [of a Port [ELEMENTS of a Network]]]
	channel speed 0x5370656564000000 8
	channel image 0x496d616765000000 20000
	ether lan "$3"
	ether field "$3"
	local name
	for name in first second; do
		echo "<Gateway name='$name' $1><Provision>"
		value Latency 1 ms
		value Omission 0
		echo "</Provision><Port network='lan' excess='pass' $2><Interface name='eth1'/></Port>"
		echo "<Port network='field' excess='pass' $2><Interface name='eth2'/></Port></Gateway>"
	done
	for name in speed image; do
		echo "<Publisher name='p-$name' channel='$name' network='lan'/>"
		echo "<Subscriber name='s-$name' channel='$name' network='field'/>"
	done
}
of() { MLCCA_SOCKET=/run/$1/control.sock ctl "${@:2}"; }
declare -A daemon relay # their process ids
start() { # start GATEWAY [OPTION of mlccad...]: daemon and relay
	mkdir -p "/run/$1/bpf" "/run/$1/state"
	mountpoint -q "/run/$1/bpf" || mount -t bpf bpf "/run/$1/bpf" || fail "no bpffs of $1"
	exec_in_ns "$1" "$mlccad" --description /run/system.xml --gateway "$1" --socket "/run/$1/control.sock" \
		--bpf-root "/run/$1/bpf" --state-directory "/run/$1/state" "${@:2}" >>"/run/$1.log" 2>&1 &
	daemon[$1]=$!
	wait_for 60 of "$1" status
	exec_in_ns "$1" setpriv --reuid $user --regid $user --clear-groups "$BUILD/mlcca-relay" \
		--socket "/run/$1/control.sock" >>"/run/$1-relay.log" 2>&1 &
	relay[$1]=$!
	relay_is_asked "${relay[$1]}"
}
carries() { [ "$(transfers_of "${relay[$1]}" "/run/$1-relay.log")" = "$2" ]; } # carries GATEWAY TRANSFERS

# The sink prints what comes: single events, and long ones put together from their fragments.
cat >/run/peer.py <<'P'
import socket, struct, sys, time
def group(subject):
    return f"239.{subject[0]}.{subject[7]}.{min(max(subject[5], 1), 254)}"
def subject_of(text):
    return text.encode().ljust(8, b"\0")[:8]
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
s.bind(("", 9999))
own = sys.argv[2]
s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(own))
s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 0)
if sys.argv[1] == "send":
    name, count, size = sys.argv[3], int(sys.argv[4]), int(sys.argv[5])
    subject, chunk = subject_of(name), 8183 - 6
    for number in range(count):
        data = (b"%07d" % number).ljust(size, b".")
        parts = [data[i:i + chunk] for i in range(0, len(data), chunk)]
        for i, part in enumerate(parts):
            left = len(parts) - 1 - i
            head = b"\0" if size <= 8183 else b"\1" + struct.pack(">BBI", 0x40 | (0x20 if i == 0 else 0) | left, 0, number)
            s.sendto(subject + head + part, (group(subject), 9999))
        time.sleep(0.05)
else:
    for name in ("Speed", "Image"):
        s.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(group(subject_of(name))) + socket.inet_aton(own))
    print("ready", flush=True)
    begun = {}
    while True:
        data, sender = s.recvfrom(65536)
        name = data[:8].rstrip(b"\0").decode()
        if data[8] == 0:
            print(name, data[9:16].decode(), sender[0], flush=True)
            continue
        head, _, number = struct.unpack(">BBI", data[9:15])
        parts = begun.setdefault((sender[0], number), {})
        parts[head & 0x1f] = data[15:]
        parts["last"] = max(parts.get("last", -1), head & 0x1f) if head & 0x20 else parts.get("last", -1)
        if parts["last"] >= 0 and len(parts) == parts["last"] + 2:
            whole = b"".join(parts[left] for left in range(parts["last"], -1, -1))
            print(name, whole[:7].decode(), sender[0], len(whole), set(whole[7:]) == {ord(".")}, flush=True)
            del begun[sender[0], number]
P
: >/run/sink
exec_in_ns sink python3 -u /run/peer.py listen 10.2.0.1 >>/run/sink &
wait_for 20 grep -q ready /run/sink
send() { in_ns source python3 /run/peer.py send 10.1.0.1 "$@"; }
events() { grep -c "^$1 .* $2" /run/sink; } # events CHANNEL SENDER: of the relay of a gateway
numbers() { grep "^$1 " /run/sink | awk '{ print $2 }'; }
