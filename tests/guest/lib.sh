# SPDX-License-Identifier: BSD-2-Clause
# For test scripts that run in the guest (bash): . tests/guest/lib.sh
#
# A namespace is a name made by `ip netns add`, or - for the one the script runs in.
# What Debian 12 does (kernel 6.1, can-utils 2020.11):
# - vxcan and vcan have no queue: `cangen -g 0 -n 100000` sends them all, none is lost on the way.
# - A gate that drops at egress gives the sender ENOBUFS: cangen then needs -i (ignore) to go on. On a
#   controller (10 frames of queue) it needs -p MS (wait) instead, or it ends at the first full queue.
# - candump loses frames of a burst with its default receive buffer (about 278 frames): -r as root.
# - can-gw ignores a frame whose destination ifindex equals the ifindex of the sender in the sender's
#   own namespace: vxcan_pair gives every interface an index of its own.
# - `ip netns exec` hides bpffs, tracefs and debugfs, because it mounts /sys again; in_ns does not.

# The guest is emulated, and gojq starts in a fifth of the time that jq takes. It sorts the keys of objects.
jq() { gojq "$@"; }

fail() {
	echo "${BASH_SOURCE[-1]}:${BASH_LINENO[-2]}: $*" >&2
	exit 1
}

# expect_eq WHAT EXPECTED ACTUAL
expect_eq() {
	[ "$2" = "$3" ] || fail "$1: expected '$2', got '$3'"
}

# wait_for SECONDS COMMAND...: until COMMAND succeeds, tried every 20 ms; fails the test when it never does. SECONDS are
# generous on a machine that does nothing else; on a busy one six times as much is waited for. What must happen within
# a time is measured by the times at which it happened, never by this limit.
wait_for() {
	comes_true "$@" || fail "never came true: ${*:2}"
}

# comes_true SECONDS COMMAND...: the same; false when it never does.
comes_true() {
	local wait_up wait_end # COMMAND sees them: names that no case has
	read -r wait_up _ </proc/uptime # hundredths of a second, and no clock that anybody sets
	wait_end=$((10#${wait_up/./} + $1 * ${PATIENCE:-6} * 100))
	shift
	until "$@" >/dev/null 2>&1; do
		read -r wait_up _ </proc/uptime
		[ $((10#${wait_up/./})) -lt "$wait_end" ] || return 1
		sleep 0.02
	done
}

# expect_becomes WHAT EXPECTED COMMAND...: what COMMAND prints, as soon as it is that. For counters and lines that
# follow what they are about.
expect_becomes() {
	prints_expected() { [ "$("${@:2}")" = "$1" ]; }
	comes_true 10 prints_expected "${@:2}" || expect_eq "$1" "$2" "$("${@:3}")"
}

# journal OPTION...: of journald, which reads what programs have written when it comes to it, with all of that.
journal() {
	journalctl --sync
	journalctl -q "$@"
}

# exec_in_ns NAMESPACE COMMAND... &: for the background, so that $! is COMMAND itself.
exec_in_ns() {
	local namespace=$1
	shift
	[ "$namespace" = - ] || set -- nsenter "--net=/run/netns/$namespace" -- "$@"
	exec "$@"
}

# in_ns NAMESPACE COMMAND...: a program, not a shell function.
in_ns() {
	(exec_in_ns "$@")
}

# into_ns NAMESPACE INTERFACE: moves it there and brings it up.
into_ns() {
	if [ "$1" != - ]; then
		[ -e "/run/netns/$1" ] || ip netns add "$1"
		ip link set "$2" netns "$1"
	fi
	in_ns "$1" ip link set "$2" up
}

# vxcan_pair NAMESPACE INTERFACE NAMESPACE INTERFACE: a CAN bus between two namespaces, both ends up.
# The namespaces are made when they do not exist.
vxcan_next_index=1000
vxcan_pair() {
	modprobe vxcan
	ip link add "$2" index $vxcan_next_index type vxcan \
		peer name "$4" index $((vxcan_next_index + 1)) || fail "no vxcan pair $2 $4"
	vxcan_next_index=$((vxcan_next_index + 2))
	into_ns "$1" "$2"
	into_ns "$3" "$4"
}

# forward NAMESPACE SOURCE DESTINATION: can-gw rules for classic and FD frames, which programs here
# see as well (-e): the gate of DESTINATION receives its own frames then, without a sender.
forward() {
	modprobe can-gw
	in_ns "$1" cangw -A -s "$2" -d "$3" -e && in_ns "$1" cangw -A -s "$2" -d "$3" -e -X ||
		fail "no can-gw rule $2 -> $3"
}

# burst NAMESPACE INTERFACE ID COUNT [CANGEN-OPTION...]: as fast as it goes; -e for 29-bit identifiers.
burst() {
	in_ns "$1" cangen "$2" -g 0 -i -I "$3" -L 8 -D i -n "$4" "${@:5}"
}

# count_frames NAME NAMESPACE INTERFACE[,FILTER...]: records what a raw socket there sees, from now on.
# Frames are lines of candump -L in $capture/NAME. Several may run at a time.
capture=$(mktemp -d /run/capture.XXXXXX)
declare -A capture_id
count_frames() {
	local before
	before=$(receivers "$2" "${3%%,*}")
	# A buffer is memory only while frames wait in it; 768 bytes for each classic frame.
	exec_in_ns "$2" candump -L -d -r 250000000 "$3" >"$capture/$1" 2>&1 &
	capture_id[$1]=$!
	wait_for 10 more_receivers "$before" "$2" "${3%%,*}"
}

receivers() {
	in_ns "$1" cat /proc/net/can/rcvlist_{all,fil,inv,sff,eff,err} | grep -c "^ *$2 "
}

more_receivers() {
	[ "$(receivers "$2" "$3")" -gt "$1" ]
}

# frames NAME: how many were recorded so far, after everything that the kernel has for it was read.
frames() {
	local id=${capture_id[$1]} quiet=0 size last=-1 status
	while [ $quiet -lt 3 ]; do
		read -r status <"/proc/$id/stat" || fail "candump of $1 has ended: $(tail -n 1 "$capture/$1")"
		size=$(stat -c %s "$capture/$1")
		# Asleep: its receive buffer is empty. Three times: nothing was under way to it either.
		case $status in *") S "*) [ "$size" = "$last" ] && quiet=$((quiet + 1)) || quiet=0 ;; *) quiet=0 ;; esac
		last=$size
		sleep 0.02
	done
	! grep -q DROPCOUNT "$capture/$1" || fail "candump of $1 lost frames: enlarge its buffer"
	grep -c '^(' "$capture/$1"
	return 0
}

# expect_frames NAME COUNT: no more and no fewer. On a busy machine frames can wait in the kernel for long
# while candump sleeps: too few are waited for, as long as some come.
expect_frames() {
	local seen=-1 before end=0
	while before=$seen && seen=$(frames "$1") || exit 1; [ "$seen" -lt "$2" ]; do
		[ "$seen" = "$before" ] || end=$((${EPOCHREALTIME/./} + 20000000))
		[ "${EPOCHREALTIME/./}" -lt "$end" ] || break
	done
	expect_eq "frames at $1" "$2" "$seen"
}

# stop_count NAME: ends the recording; the file stays.
stop_count() {
	kill "${capture_id[$1]}"
	wait "${capture_id[$1]}"
	unset "capture_id[$1]"
}
