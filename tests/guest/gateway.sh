# SPDX-License-Identifier: BSD-2-Clause
# For guest tests of the daemon (bash): . tests/guest/gateway.sh
#
# The gateway is the namespace of the script: can0, can1 and can2 lead to the namespaces robot, second
# and third, where foreign nodes send and listen on r0, s0 and t0.
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

mlccad=$BUILD/mlccad
run=/run/mlcca
state=/run/mlcca-state
export MLCCA_SOCKET=$run/control.sock
# On a busy machine an answer takes longer than the 10 s that a person waits.
ctl() { "$BUILD/mlccactl" --timeout 60 "$@"; }

three_buses() {
	modprobe -a can-raw can-gw vxcan
	vxcan_pair robot r0 - can0
	vxcan_pair second s0 - can1
	vxcan_pair third t0 - can2
}

bpffs() {
	mkdir -p $run/bpf $state
	mount -t bpf bpf $run/bpf || fail "no bpffs"
}

# pins: the directory of what the running daemon has pinned. Its name has the version of the layout.
pins() { echo $run/bpf/v*; }

# pins_of INTERFACE: those of its gate.
pins_of() { echo "$(pins)/if$(cat /sys/class/net/"$1"/ifindex)"; }

# start_daemon DESCRIPTION [OPTION...]: in the background; returns when it answers.
start_daemon() {
	"$mlccad" --description "$1" --socket $MLCCA_SOCKET --bpf-root $run/bpf \
		--state-directory $state "${@:2}" >>/run/mlccad.log 2>&1 &
	daemon_id=$!
	wait_for 60 ctl status
}

# The daemon's exit status.
daemon_end() {
	wait "$daemon_id"
}

# --- descriptions ----------------------------------------------------------------------------------

# value NAME VALUE [UNIT]: units s, ms, bytes, bytes/s
value() {
	echo "<Attribute><Name>$1</Name>"
	case $3 in
	s) echo '<Dimension><SIUnit><Seconds>1</Seconds></SIUnit></Dimension>' ;;
	ms) echo '<Dimension><SIUnit><Seconds>1</Seconds></SIUnit><Magnitude>-3</Magnitude></Dimension>' ;;
	bytes) echo '<Dimension><SIUnit><Bytes>1</Bytes></SIUnit></Dimension>' ;;
	bytes/s) echo '<Dimension><SIUnit><Bytes>1</Bytes><Seconds>-1</Seconds></SIUnit></Dimension>' ;;
	esac
	echo "<Value>$2</Value></Attribute>"
}

# channel NAME SUBJECT BYTES [OMISSION]
channel() {
	echo "<EventChannel name='$1'><SubjectUID>$2</SubjectUID><Description>$1</Description><Attributes>"
	value Period 50 ms
	value MaxPayload "$3" bytes
	value Omission "${4:-2}"
	echo '</Attributes></EventChannel>'
}

# network NAME PROFILE BINDING...: each binding is an element of the description. A virtual bus carries
# more than its bit rate says: a test that makes use of it sets measured to false. One with FD frames states the
# bit rate of their data phase.
measured=true
data_bitrate=
network() {
	echo "<Network name='$1'><Kind>can</Kind><Profile>$2</Profile>"
	echo "<Bus bitrate='500000' ${data_bitrate:+data-bitrate='$data_bitrate'} measured='$measured'/><Provision>"
	value Latency 5 ms
	value Period 1 ms
	value Omission 0
	value Bandwidth 50000 bytes/s
	value MaxPayload 64 bytes
	echo '</Provision>'
	printf '%s\n' "${@:3}"
	echo '</Network>'
}

# gateway OMISSION PORT...: each port is "NETWORK INTERFACE-ATTRIBUTES [PORT-ATTRIBUTES]". Tests send as fast
# as they can: what is more than was admitted passes, unless a test sets excess to drop.
# Nor shall frames come twice while a test makes rules for can-gw by hand: unless it sets forwarder to can-gw,
# the daemon makes none.
excess=pass
forwarder=none
gateway() {
	echo "<Gateway name='bridge' forward='$forwarder'><Provision>"
	value Latency 1 ms
	value Omission "$1"
	echo '</Provision>'
	local port words
	for port in "${@:2}"; do
		read -r -a words <<<"$port"
		echo "<Port network='${words[0]}' excess='$excess' ${words[2]}><Interface ${words[1]}/>${words[3]}</Port>"
	done
	echo '</Gateway>'
}

# heart_beat_system OMISSION: the emergency switch on second-can, motors on robot-can, famouso profile.
heart_beat_id=1F480064 # priority 7D, node 20, etag 64
heart_beat_system() {
	local etag='<Binding channel="emergency-switch"><ETag>0x64</ETag></Binding>'
	echo '<System name="volksbot">'
	channel emergency-switch 0xa4efeccc3210b497 8
	network robot-can famouso "$etag"
	network second-can famouso "$etag"
	network third-can famouso "$etag"
	gateway "$1" "robot-can name='can0'" "second-can name='can1'" "third-can name='can2'"
	echo '<Publisher name="switch" channel="emergency-switch" network="second-can" node="0x20"/>'
	echo '<Subscriber name="motors" channel="emergency-switch" network="robot-can"/>'
	echo '</System>'
}

# relay_is_asked PID: it would end by a SIGUSR1 before it waits for that.
relay_is_asked() {
	wait_for 20 grep -q 'SigBlk:.*4202' "/proc/$1/status"
}

# transfers_of PID LOG: how many transfers a relay carries, which it prints at a SIGUSR1; nothing when it does not. Never
# what it has printed before.
transfers_of() {
	local before
	before=$(prints_of_relay "$2")
	has_printed() { [ "$(prints_of_relay "$1")" -gt "$before" ]; }
	kill -USR1 "$1" && comes_true 2 has_printed "$2" && grep -o '^[0-9]* transfers\? on' "$2" | tail -n 1 | cut -d ' ' -f 1
}
prints_of_relay() { grep -c '^[0-9]* transfers\? on' "$1"; }
