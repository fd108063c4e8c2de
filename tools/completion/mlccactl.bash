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

_mlccactl() {
	local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]}
	local verbs="status networks channels query admit release explain monitor mode reload"
	local common="--socket --timeout --json --no-color --help"
	local attributes="Latency= Jitter= Deadline= Period= Bandwidth= PacketLoss= Omission= MaxPayload="
	local verb= word i
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
	--socket)
		mapfile -t COMPREPLY < <(compgen -f -- "$cur")
		return
		;;
	--from | --to)
		mapfile -t COMPREPLY < <(compgen -W "$(_mlccactl_places)" -- "$cur")
		return
		;;
	--require | --offer)
		mapfile -t COMPREPLY < <(compgen -W "$attributes" -- "$cur")
		compopt -o nospace 2>/dev/null
		return
		;;
	--user)
		mapfile -t COMPREPLY < <(compgen -u -- "$cur")
		return
		;;
	--timeout | --node | --priority | --id | --subscriber | --publisher) return ;;
	esac

	local words=$common
	case $verb in
	"") words="$verbs $common --version" ;;
	query | admit)
		words+=" --from --to --require --offer --node --priority --user --subscriber --publisher"
		;;
	release) words+=" --id" ;;
	mode) [[ $cur == -* ]] || words="enforce audit" ;;
	esac
	case $verb in
	query | admit | release | explain)
		[[ $cur == -* ]] || words=$(_mlccactl_channels)
		;;
	esac
	mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur")
}

complete -F _mlccactl mlccactl
