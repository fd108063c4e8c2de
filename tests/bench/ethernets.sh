# SPDX-License-Identifier: BSD-2-Clause
# To be sourced as root in a network namespace of its own, with $build: right0 leads to a namespace that receives, and
# bus0 to bus3 to one that sends as many events as four full buses of 1 Mbit/s bring.
ip link set lo up
for side in left right; do
	unshare -n sleep infinity &
	holder[${#holder[@]}]=$!
done
sleep 0.2
link() { # link INTERFACE PROCESS NUMBER
	ip link add "$1" type veth peer name "far$3" netns "$2"
	ip addr add "10.$3.0.1/24" dev "$1"
	ip link set "$1" up
	nsenter -t "$2" -n sh -c "ip addr add 10.$3.0.2/24 dev far$3; ip link set far$3 up; ip link set lo up"
}
link right0 "${holder[1]}" 2
for i in 0 1 2 3; do link "bus$i" "${holder[0]}" $((3 + i)); done

# Nanoseconds of a processor that processes have had.
used_by() {
	local all=0 process one
	for process in "$@"; do read -r one _ <"/proc/$process/schedstat" && all=$((all + one)); done
	echo $all
}

# full_rate EVENTS-OF-EACH PROCESS...: how many arrive at the right, and what the processes take of a processor meanwhile
full_rate() {
	local count=$1 before events
	shift
	before=$(used_by "$@")
	events=$(nsenter -t "${holder[0]}" -n "$build/bench/probe" rate 10.2.0.2 "/proc/${holder[1]}/ns/net" "$count" \
		130000 10.3.0.2 10.4.0.2 10.5.0.2 10.6.0.2)
	echo "$events, $(awk -v used=$(($(used_by "$@") - before)) -v events=$((4 * count)) \
		'{ printf "%.1f %% of a processor", used / events * $(NF - 2) / 1e7 }' <<<"$events")"
}
