# SPDX-License-Identifier: BSD-2-Clause
# bash completion for mlccactl; names of channels and places are asked from the running daemon.

# Of what the daemon answers to verb $1, the names that are followed by field $2.
_mlccactl_names() {
	mlccactl --timeout 1 --json "$1" 2>/dev/null |
		grep -oE "\"name\":\"[^\"\\]*\",\"$2\"" | cut -d'"' -f4 | sort -u
}

_mlccactl_channels() {
	_mlccactl_names channels description
}

_mlccactl_places() {
	_mlccactl_names networks kind
	mlccactl --timeout 1 --json networks 2>/dev/null | grep -oE '"gateways":\[[^]]*\]' |
		cut -d: -f2 | grep -oE '[^][",]+' | sort -u
}

_mlccactl_gates() {
	mlccactl --timeout 1 --json gate 2>/dev/null | grep -oE '"(interface|network)":"[^"\\]*"' |
		cut -d'"' -f4 | sort -u
}

# The profiles that learn takes.
_mlccactl_profiles() {
	mlccactl learn --help 2>/dev/null | grep -oE 'INTERFACE=[a-z0-9|]+' | cut -d= -f2 | tr '|' '\n'
}

# CAN interfaces: ARPHRD_CAN is 280.
_mlccactl_can() {
	grep -lx 280 /sys/class/net/*/type 2>/dev/null | cut -d/ -f5
}

# Those of Ethernet, which are 1, as well.
_mlccactl_learnable() {
	grep -lxE '1|280' /sys/class/net/*/type 2>/dev/null | cut -d/ -f5
}

# Offers the lines of the standard input that begin with what is typed, each with $1 appended. They
# are not expanded, as the words of compgen -W are: a name may be somebody else's.
_mlccactl_offer() {
	local name
	while IFS= read -r name; do
		[[ $name != "$cur"* ]] || COMPREPLY+=("$(printf %q "$name")$1")
	done
}

_mlccactl() {
	local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]}
	local verbs="status networks channels routes reservations subscriptions cluster gate query what-if announce admit renew release withdraw"
	verbs+=" reinstate explain history report monitor top audit mode reload bandwidth"
	local others="analyse-bus check describe export format generate import learn new rollout doctor"
	local common="--socket --timeout --json --no-color --help"
	local offline="--json --no-color --help"
	local attributes="Latency= Jitter= Deadline= Period= Bandwidth= PacketLoss= Omission= MaxPayload="
	local verb= word i names=
	COMPREPLY=()

	for ((i = 1; i < COMP_CWORD; i++)); do
		word=${COMP_WORDS[i]}
		case $word in
		--socket | --timeout) ((i++)) ;;
		-*) ;;
		*) verb=$word && break ;;
		esac
	done

	case $prev in
	--socket | --output | -o | --bpf-root)
		mapfile -t COMPREPLY < <(compgen -f -- "$cur")
		return
		;;
	--format)
		local forms="text json sarif html"
		[[ $verb == import ]] && forms="dbc eds cyphal dds-xml ros2-params ros2-topics"
		[[ $verb == export ]] && forms="dbc can-gw em_canid wireshark"
		mapfile -t COMPREPLY < <(compgen -W "$forms" -- "$cur")
		return
		;;
	--from | --to | --without | --off)
		_mlccactl_offer < <(_mlccactl_places)
		return
		;;
	--require | --offer | --set)
		mapfile -t COMPREPLY < <(compgen -W "$attributes" -- "$cur")
		compopt -o nospace 2>/dev/null
		return
		;;
	--user)
		mapfile -t COMPREPLY < <(compgen -u -- "$cur")
		return
		;;
	--unset)
		mapfile -t COMPREPLY < <(compgen -W "${attributes//=/}" -- "$cur")
		return
		;;
	--kind)
		mapfile -t COMPREPLY < <(compgen -W "started stopped granted refused withdrawn revoked network-down removed degraded upgraded rerouted released
			reinstated dropped policed missing restored late interface gateway mode reload lapsed
			drift bypass binding rollout problem" -- "$cur")
		return
		;;
	--by)
		mapfile -t COMPREPLY < <(compgen -W "subject network" -- "$cur")
		return
		;;
	--sort)
		mapfile -t COMPREPLY < <(compgen -W "name route verdict rate jitter loss drops reserved used" -- "$cur")
		return
		;;
	--can)
		_mlccactl_offer < <(_mlccactl_can)
		return
		;;
	--domain)
		mapfile -t COMPREPLY < <(compgen -W "single-domain 1-hop 2-hop 3-hop" -- "$cur")
		return
		;;
	--profile)
		if [[ $verb == learn ]]; then
			_mlccactl_offer = < <(_mlccactl_learnable)
			compopt -o nospace 2>/dev/null
			return
		fi
		mapfile -t COMPREPLY < <(compgen -W "raw j1939" -- "$cur")
		return
		;;
	--merge)
		mapfile -t COMPREPLY < <(compgen -f -X '!*.xml' -- "$cur"; compgen -d -- "$cur")
		compopt -o filenames 2>/dev/null
		return
		;;
	--interface)
		_mlccactl_offer < <(_mlccactl_can)
		return
		;;
	--safe-side)
		mapfile -t COMPREPLY < <(compgen -W "drop deliver none" -- "$cur")
		return
		;;
	--out)
		mapfile -t COMPREPLY < <(compgen -d -- "$cur")
		return
		;;
	--timeout | --node | --priority | --id | --admission | --subscriber | --publisher | --identifier | --from-node | --to-node | --address) return ;;
	--packet | --header | --overhead-us | --loss | --limit | --background | --demand) return ;;
	--network | --gateway)
		[[ $verb == cluster ]] && _mlccactl_offer < <(_mlccactl_places)
		return
		;;
	--bitrate | --data-bitrate)
		if [[ $verb == learn ]]; then
			_mlccactl_offer = < <(_mlccactl_learnable)
			compopt -o nospace 2>/dev/null
		fi
		return
		;;
	--background-load | --faults | --fault-interval-ms) return ;;
	--fifo-depth | --bus-off) return ;;
	--delay | --count | --filter | -d | -n) return ;;
	--key | --lease | --when-clean | --link | --since | --until | --default-period) return ;;
	--channel)
		if [[ $verb == history ]]; then
			_mlccactl_offer < <(_mlccactl_channels)
		fi
		return
		;;
	--subject | --name | --description | --set-user | --remove-set | --component) return ;;
	esac

	# bash makes words of their own of INTERFACE, "=" and PROFILE.
	if [[ $verb == learn ]]; then
		i=$((COMP_CWORD - 1))
		if [[ $cur == "=" ]]; then
			cur=""
			i=$COMP_CWORD
		fi
		if [[ ${COMP_WORDS[i]} == "=" && ${COMP_WORDS[i - 2]} == --profile ]]; then
			mapfile -t COMPREPLY < <(compgen -W "$(_mlccactl_profiles)" -- "$cur")
			return
		fi
	fi

	local words=$common
	case $verb in
	"") words="$verbs $others $common --version" ;;
	analyse-bus)
		words="--network --bitrate --data-bitrate --unknown-senders --background-load --faults"
		words+=" --fault-interval-ms --assign $offline"
		;;
	check) words="--format --output --force --watch $offline" ;;
	describe)
		words="--channel --subject --random-subject --name --description --safe-side --set --set-user"
		words+=" --unset --priority --remove-set --dry-run $offline"
		;;
	format) words="--short --paper --in-place --output --force $offline" ;;
	rollout) words+=" --off --wait --back --accept --force --cancel" ;;
	doctor) words="--can --send --id --fifo-depth --bus-off --bpf-root --json --help" ;;
	generate) words="--component --out --force $offline" ;;
	learn)
		words="--for --output --merge --profile --bitrate --data-bitrate --name --gateway --user --no-local $offline"
		if [[ $cur != -* ]]; then
			mapfile -t COMPREPLY < <(compgen -f -- "$cur")
			_mlccactl_offer < <(_mlccactl_learnable)
			compopt -o filenames 2>/dev/null
			return
		fi
		;;
	export) words="--format --network --gateway --output --force $offline" ;;
	import)
		words="--format --name --network --gateway --interface --profile --node --bitrate --data-bitrate"
		words+=" --default-period --output $offline"
		;;
	new) words="--name --gateway --network --channel --dry-run $offline" ;;
	query | admit)
		words+=" --from --to --require --offer --node --priority --user --subscriber --publisher --subject --identifier --from-node --to-node --address"
		;;
	status) words+=" --check" ;;
	report) words+=" --html" ;;
	withdraw) words+=" --yes" ;;
	release) words+=" --id --admission --key" ;;
	renew) words+=" --id --admission --key" ;;
	what-if) words+=" --link --without --one-way" ;;
	history) words+=" --channel --kind --since --until --limit" ;;
	top) words+=" --delay --batch --count --by --sort --reverse --filter" ;;
	bandwidth)
		words+=" --packet --header --overhead-us --loss --limit --background --domain --demand"
		;;
	mode)
		words+=" --when-clean"
		[[ $cur == -* ]] || words="enforce audit"
		;;
	cluster)
		words+=" --gateway --network --check --yes --until-restart"
		[[ $cur == -* ]] || words="status members reservations drain join"
		;;
	audit)
		words+=" --xml"
		[[ $cur == -* ]] || words="report"
		;;
	esac
	case $verb in
	admit) words+=" --key --lease --hold" ;;
	announce)
		words+=" --name --state --follow"
		[[ $cur == -* || $prev == announce ]] || words="publisher subscriber"
		;;
	reservations) [[ $cur == -* ]] || names=_mlccactl_places ;;
	gate)
		words+=" --verify"
		[[ " ${COMP_WORDS[*]} " == *" --verify "* ]] && words="--no-probes --bpf-root --state-directory --json --help"
		[[ $cur == -* ]] || names=_mlccactl_gates
		;;
	esac
	case $verb in
	cluster)
		[[ $cur == -* || ! $prev =~ ^(reservations|drain|join)$ ]] || names=_mlccactl_places
		;;
	announce)
		[[ $prev != announce || $cur == -* ]] || names=_mlccactl_channels
		;;
	query | admit | release | withdraw | reinstate | explain)
		[[ $cur == -* ]] || names=_mlccactl_channels
		;;
	analyse-bus | check | describe | export | format | generate | import | new | rollout)
		if [[ $cur != -* ]]; then
			local kinds='*.xml'
			[[ $verb == analyse-bus ]] && kinds='*.@(xml|csv)'
			[[ $verb == import ]] && kinds='*.@(dbc|DBC|eds|EDS|dcf|DCF|yaml|yml|json|txt|xml)'
			# Folders too: they lead to files.
			mapfile -t COMPREPLY < <(compgen -f -X "!$kinds" -- "$cur"; compgen -d -- "$cur")
			compopt -o filenames 2>/dev/null
			return
		fi
		;;
	esac
	if [[ $names ]]; then
		_mlccactl_offer < <($names)
		return
	fi
	mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur")
}

complete -F _mlccactl mlccactl
