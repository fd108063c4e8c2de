# SPDX-License-Identifier: BSD-2-Clause
# For guest tests with radios (bash): . tests/guest/radios.sh
#
# mac80211_hwsim gives radios that receive each other without loss. Radio 0, 1, 2 is the interface
# mesh0 in the namespace node0, node1, node2, with the address 02:00:00:00:0N:00.
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

radio=(02:00:00:00:00:00 02:00:00:00:01:00 02:00:00:00:02:00)

# three_radios [MTU]: each in its namespace as an 802.11s mesh point that is up and has joined nothing.
three_radios() {
	local i
	modprobe mac80211_hwsim radios=3 || fail "no radios"
	for i in 0 1 2; do
		[ -e /run/netns/node$i ] || ip netns add node$i
		radio_point $i node$i "${1:-1500}"
	done
}

# radio_point N NAMESPACE MTU: the same of one radio, in a namespace that is there, or (-) in this one.
radio_point() {
	[ "$2" = - ] || iw phy "phy$1" set netns name "$2" || fail "phy$1 cannot move"
	in_ns "$2" ip link set lo up
	in_ns "$2" iw dev "wlan$1" set type mp || fail "wlan$1 is no mesh point"
	in_ns "$2" ip link set "wlan$1" name mesh0 mtu "$3"
	in_ns "$2" ip link set mesh0 up
}

# isolate N: no radio receives radio N from now on, nor does it receive any.
isolate() {
	echo 2 >/sys/kernel/debug/ieee80211/phy$1/hwsim/group
}

# watch NAMESPACE KIND INTERFACE: a link source there, from now on.
watch() {
	exec {watched}< <(in_ns "$1" "$BUILD/tests/watch-source" "${@:2}")
}

# await SECONDS CONDITION...: takes snapshots until the condition, a function that reads $line, is
# true of one; fails the test when none is. SECONDS are those of wait_for.
await() {
	local left=$(($1 * ${PATIENCE:-6} * 1000000)) line_before=$line
	local end=$((${EPOCHREALTIME/./} + left))
	shift
	while [ $left -gt 0 ] && read -r -t $((left / 1000000 + 1)) -u "$watched" line; do
		! "$@" || return 0
		left=$((end - ${EPOCHREALTIME/./}))
	done
	fail "never reported: $*; last: ${line:-$line_before}"
}

# link FROM TO: sets $rate (bit/s), $kind and $age (ms) of the link in $line; false if it is not there.
link() {
	[[ $line =~ \"from\":\"$1\",\"to\":\"$2\",\"rate\":([0-9]+),\"kind\":\"([a-z]+)\",\"age_ms\":([0-9]+) ]] ||
		return
	rate=${BASH_REMATCH[1]} kind=${BASH_REMATCH[2]} age=${BASH_REMATCH[3]}
}

# next_hop FROM TO VIA
next_hop() {
	[[ $line == *"{\"from\":\"$1\",\"to\":\"$2\",\"via\":\"$3\"}"* ]]
}

problem() {
	[[ $line == *"\"problem\":\"$1"* ]]
}

# ms_since MICROSECONDS: from then, by the clock of the machine, to the snapshot in $line.
ms_since() {
	[[ $line =~ \"at\":([0-9]+) ]] || fail "no time in $line"
	echo $(((BASH_REMATCH[1] - $1) / 1000))
}

# traffic NAMESPACE ADDRESS: datagrams of 1000 bytes, at most 50 a second, until stop_traffic. The pace
# is the time-out of a pipe that says nothing: a program for each pause would be slower than that.
traffic() {
	exec_in_ns "$1" bash -c 'exec 3>"/dev/udp/$0/9" 4<> <(:)
		while :; do printf %01000d 0 >&3; read -r -t 0.02 -u 4; done' "$2" 2>/dev/null &
	traffic_id=$!
}
stop_traffic() {
	kill "$traffic_id"
	wait "$traffic_id" 2>/dev/null
}
