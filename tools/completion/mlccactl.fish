# SPDX-License-Identifier: BSD-2-Clause
# fish completion for mlccactl; names of channels and places are asked from the running daemon.

# The words behind mlccactl that are neither options nor their values: the verb comes first.
function __mlccactl_words
    set -l takes --socket --timeout --subject --identifier --from --to --from-node --to-node \
        --require --offer --node --priority --address --user --subscriber --publisher --key --lease \
        --id --admission --name --state --when-clean --network --gateway
    set -l skip 0
    for word in (commandline -opc)[2..]
        if test $skip = 1
            set skip 0
        else if contains -- $word $takes
            set skip 1
        else if not string match -q -- '-*' $word
            echo $word
        end
    end
end

function __mlccactl_verb
    set -l words (__mlccactl_words)
    contains -- "$words[1]" $argv
end

# Whether argument number $argv[1] of one of the verbs behind it is being written.
function __mlccactl_argument
    set -l words (__mlccactl_words)
    test (count $words) = $argv[1]; and contains -- "$words[1]" $argv[2..]
end

function __mlccactl_verifies
    __mlccactl_verb gate; and contains -- --verify (commandline -opc)
end

function __mlccactl_no_verb
    test (count (__mlccactl_words)) = 0
end

# All but those that need no daemon.
function __mlccactl_asks
    not __mlccactl_verifies; and not __mlccactl_verb analyse-bus check describe export format \
        generate learn import new doctor
end

function __mlccactl_colours
    not __mlccactl_verifies; and not __mlccactl_verb doctor
end

# Of what the daemon answers to verb $argv[1], the names that are followed by field $argv[2].
function __mlccactl_names
    mlccactl --timeout 1 --json $argv[1] 2>/dev/null |
        string match -ra '"name":"[^"\\\\]*","'$argv[2]'"' | string replace -r '"name":"(.*)","[a-z]*"' '$1'
end

function __mlccactl_channels
    __mlccactl_names channels description
end

function __mlccactl_places
    __mlccactl_names networks kind
    mlccactl --timeout 1 --json networks 2>/dev/null | string match -ra '"gateways":\[[^]]*\]' |
        string replace '"gateways":' '' | string match -ra '[^][",]+'
end

function __mlccactl_gates
    mlccactl --timeout 1 --json gate 2>/dev/null | string match -ra '"(?:interface|network)":"[^"\\\\]*"' |
        string replace -r '".*":"(.*)"' '$1'
end

# CAN interfaces: ARPHRD_CAN is 280.
function __mlccactl_can
    set -l types /sys/class/net/*/type
    test -n "$types"; and string replace -rf '.*/([^/]*)/type$' '$1' -- (grep -lx 280 $types)
end

# Those of Ethernet, which are 1, as well.
function __mlccactl_learnable
    set -l types /sys/class/net/*/type
    test -n "$types"; and string replace -rf '.*/([^/]*)/type$' '$1' -- (grep -lxE '1|280' $types)
end

# The profiles that learn takes.
function __mlccactl_profiles
    mlccactl learn --help 2>/dev/null | string match -rg 'INTERFACE=([a-z0-9|]+)' | string split '|'
end

# INTERFACE=, and behind it each of $argv.
function __mlccactl_of_interface
    set -l interface (string match -rg '^(?:--[a-z-]*=)?([^=]+=)' -- (commandline -ct))
    if test -n "$interface"
        string join \n -- $interface$argv
    else
        string replace -r '$' '=' -- (__mlccactl_learnable)
    end
end

# Files whose names end in one of these, and the folders that lead to them.
function __mlccactl_files
    set -l endings (string join '|' $argv)
    __fish_complete_path (commandline -ct) | string match -ri '^[^\t]*(?:/|\.(?:'$endings'))(?=\t|$)'
end

set -g __mlccactl_attributes Latency Jitter Deadline Period Bandwidth PacketLoss Omission MaxPayload

# __mlccactl_option VERBS OPTION...: an option of these verbs, with what complete(1) takes.
function __mlccactl_option
    complete -c mlccactl -n "__mlccactl_verb $argv[1]" $argv[2..]
end

complete -c mlccactl -f
complete -c mlccactl -s h -l help -d 'print help'
complete -c mlccactl -l json -d 'print JSON'
complete -c mlccactl -n __mlccactl_colours -l no-color -d 'no colour on a terminal'
complete -c mlccactl -n __mlccactl_asks -l socket -r -F -d 'control socket of mlccad'
complete -c mlccactl -n __mlccactl_asks -l timeout -x -d 'seconds that mlccad may take to answer'
complete -c mlccactl -n __mlccactl_no_verb -l version -d 'print the version'

complete -c mlccactl -n __mlccactl_no_verb -a status -d 'what the gateway does and sees, and what is wrong'
complete -c mlccactl -n __mlccactl_no_verb -a networks -d 'what the networks provide, and what of it is reserved'
complete -c mlccactl -n __mlccactl_no_verb -a channels -d 'every delivery with its verdict and its frames'
complete -c mlccactl -n __mlccactl_no_verb -a routes -d 'the routes between networks, the links of the meshes, the rules of can-gw'
complete -c mlccactl -n __mlccactl_no_verb -a reservations -d 'what has been promised to whom, and what is left'
complete -c mlccactl -n __mlccactl_no_verb -a subscriptions -d 'who may subscribe over networks, and what is subscribed further on'
complete -c mlccactl -n __mlccactl_no_verb -a cluster -d 'gateways that share networks through a store'
complete -c mlccactl -n __mlccactl_no_verb -a gate -d 'what the gates hold'
complete -c mlccactl -n __mlccactl_no_verb -a query -d 'would this be admitted? changes nothing'
complete -c mlccactl -n __mlccactl_no_verb -a what-if -d 'who would lose, who would gain? changes nothing'
complete -c mlccactl -n __mlccactl_no_verb -a announce -d 'announce a program as the publisher or subscriber that is described for it'
complete -c mlccactl -n __mlccactl_no_verb -a admit -d 'admit a new publisher or subscriber of a channel'
complete -c mlccactl -n __mlccactl_no_verb -a renew -d 'start the lease of an admission again'
complete -c mlccactl -n __mlccactl_no_verb -a release -d 'end run-time admissions'
complete -c mlccactl -n __mlccactl_no_verb -a withdraw -d 'refuse everything of a channel, also what is described'
complete -c mlccactl -n __mlccactl_no_verb -a reinstate -d 'undo withdraw'
complete -c mlccactl -n __mlccactl_no_verb -a explain -d 'why a channel is granted or refused, attribute by attribute'
complete -c mlccactl -n __mlccactl_no_verb -a history -d 'what was decided, and why'
complete -c mlccactl -n __mlccactl_no_verb -a report -d 'the gateway as it is now, as one page of HTML'
complete -c mlccactl -n __mlccactl_no_verb -a monitor -d 'print events as they happen'
complete -c mlccactl -n __mlccactl_no_verb -a top -d 'a live screen of rates, jitter, loss and drops'
complete -c mlccactl -n __mlccactl_no_verb -a audit -d 'what was refused, or would have been'
complete -c mlccactl -n __mlccactl_no_verb -a mode -d 'enforce, or audit'
complete -c mlccactl -n __mlccactl_no_verb -a reload -d 'read the description again, all or nothing'
complete -c mlccactl -n __mlccactl_no_verb -a bandwidth -d 'what a chain of radio links carries'
complete -c mlccactl -n __mlccactl_no_verb -a analyse-bus -d 'response times of the messages of a CAN bus'
complete -c mlccactl -n __mlccactl_no_verb -a check -d 'find what cannot work in the description of a system'
complete -c mlccactl -n __mlccactl_no_verb -a describe -d 'create and edit the description of an event channel'
complete -c mlccactl -n __mlccactl_no_verb -a export -d 'what a description admits, for other tools'
complete -c mlccactl -n __mlccactl_no_verb -a format -d 'attributes in the short form or in that of the paper'
complete -c mlccactl -n __mlccactl_no_verb -a generate -d 'C++ and DER from the description of a system'
complete -c mlccactl -n __mlccactl_no_verb -a learn -d 'draft a description from the traffic that is there'
complete -c mlccactl -n __mlccactl_no_verb -a import -d 'describe a network from DBC, CANopen, Cyphal, ROS 2 or DDS files'
complete -c mlccactl -n __mlccactl_no_verb -a new -d 'the first description of a system'
complete -c mlccactl -n __mlccactl_no_verb -a rollout -d 'one description for all gateways of a cluster'
complete -c mlccactl -n __mlccactl_no_verb -a doctor -d 'examine a CAN controller before it is trusted'

complete -c mlccactl -n '__mlccactl_argument 1 query admit announce release withdraw reinstate explain' -a '(__mlccactl_channels)'
complete -c mlccactl -n '__mlccactl_argument 1 reservations' -a '(__mlccactl_places)'
complete -c mlccactl -n '__mlccactl_argument 1 gate' -a '(__mlccactl_gates)'
complete -c mlccactl -n '__mlccactl_argument 2 announce' -a 'publisher subscriber'
complete -c mlccactl -n '__mlccactl_argument 1 mode' -a 'enforce audit'
complete -c mlccactl -n '__mlccactl_argument 1 audit' -a report
complete -c mlccactl -n '__mlccactl_argument 1 cluster' -a 'status members reservations drain join'
complete -c mlccactl -n '__mlccactl_argument 2 cluster' -a '(__mlccactl_places)'

__mlccactl_option 'cluster' -l network -x -a '(__mlccactl_places)' -d 'reservations of this network'
__mlccactl_option 'cluster' -l gateway -x -a '(__mlccactl_places)' -d 'reservations of this gateway'
__mlccactl_option 'status cluster' -l check -d 'one line for a monitoring system'
__mlccactl_option 'gate' -l verify -d 'read back what is in force, without the daemon'
complete -c mlccactl -n __mlccactl_verifies -l no-probes -d 'send no frames through copies of gates'
complete -c mlccactl -n __mlccactl_verifies -l bpf-root -x -a '(__fish_complete_directories)' -d 'where the gates are pinned'
complete -c mlccactl -n __mlccactl_verifies -l state-directory -x -a '(__fish_complete_directories)' -d 'where the journal is'

__mlccactl_option 'query admit' -l subject -x -d 'a channel that is not described'
__mlccactl_option 'query admit' -l identifier -x -d 'of such a channel on a CAN network'
__mlccactl_option 'query admit' -l from -x -a '(__mlccactl_places)' -d 'place of a new publisher'
__mlccactl_option 'query admit' -l to -x -a '(__mlccactl_places)' -d 'place of a new subscriber'
__mlccactl_option 'query admit' -l from-node -x -d 'node of that mesh where the publisher is'
__mlccactl_option 'query admit' -l to-node -x -d 'node of that mesh where the subscriber is'
__mlccactl_option 'query admit' -l require -x -a '$__mlccactl_attributes=' -d 'what the new subscriber requires'
__mlccactl_option 'query admit' -l offer -x -a '$__mlccactl_attributes=' -d 'what the new publisher offers'
__mlccactl_option 'query admit' -l node -x -d 'node of the new publisher'
__mlccactl_option 'query admit' -l priority -x -d 'FAMOUSO priority of its events'
__mlccactl_option 'query admit' -l address -x -d 'address that the new publisher sends from'
__mlccactl_option 'query admit' -l user -x -a '(__fish_complete_users)' -d 'user that may send'
__mlccactl_option 'query admit' -l subscriber -x -d 'name of the new subscriber, for reports'
__mlccactl_option 'query admit' -l publisher -x -d 'name of the new publisher, for reports'
__mlccactl_option 'admit' -l key -x -d 'a name of your own for this admission'
__mlccactl_option 'admit' -l lease -x -d 'release it unless it is renewed in this time'
__mlccactl_option 'admit' -l hold -d 'stay, renew the lease and print what happens to it'
__mlccactl_option 'renew release' -l id -x -d 'one admission, as admit and explain name it'
__mlccactl_option 'renew release' -l admission -x -d 'one admission, as admit and explain name it'
__mlccactl_option 'renew release' -l key -x -d 'one admission, by the key that admit was given'
__mlccactl_option 'withdraw cluster' -s y -l yes -d 'do not ask for confirmation'
__mlccactl_option cluster -l until-restart -d 'of drain: until mlccad is started again'
__mlccactl_option 'announce' -l name -x -d 'name of that publisher or subscriber'
__mlccactl_option 'announce' -l state -x -a '$__mlccactl_attributes=' -d 'what the program was made with'
__mlccactl_option 'announce' -l follow -d 'stay and print the events of the channel'
__mlccactl_option 'what-if' -l link -x -d 'a link of a mesh at this rate'
__mlccactl_option 'what-if' -l without -x -a '(__mlccactl_places)' -d 'a network or gateway that is not there'
__mlccactl_option 'what-if' -l one-way -d 'the links only from FROM to TO'

__mlccactl_option 'history' -l channel -x -a '(__mlccactl_channels)' -d 'of this channel only'
__mlccactl_option 'history' -l kind -x -a 'started stopped granted refused withdrawn revoked network-down removed degraded upgraded rerouted released reinstated dropped policed missing restored late interface gateway mode reload lapsed drift bypass binding rollout problem' -d 'only these entries'
__mlccactl_option 'history' -l since -x -d 'not before'
__mlccactl_option 'history' -l until -x -d 'not after'
__mlccactl_option 'history' -l limit -x -d 'the newest ones'
__mlccactl_option 'report' -l html -d 'one file that loads nothing'
__mlccactl_option 'top' -s d -l delay -x -d 'seconds between two polls'
__mlccactl_option 'top' -s b -l batch -d 'print one table after the other'
__mlccactl_option 'top' -s n -l count -x -d 'end after this number of tables'
__mlccactl_option 'top' -l by -x -a 'subject network' -d 'what has a row'
__mlccactl_option 'top' -l sort -x -a 'name route verdict rate jitter loss drops reserved used' -d 'by this column'
__mlccactl_option 'top' -l reverse -d 'the smallest first'
__mlccactl_option 'top' -l filter -x -d 'only rows that contain this text'
__mlccactl_option 'mode' -l when-clean -x -d 'when nothing would have been dropped for this time'
__mlccactl_option 'audit' -l xml -d 'only the elements that a description would need'

__mlccactl_option 'bandwidth' -l packet -x -d 'payload of a packet'
__mlccactl_option 'bandwidth' -l header -x -d 'sent with each packet'
__mlccactl_option 'bandwidth' -l overhead-us -x -d 'time for each packet beside its bits'
__mlccactl_option 'bandwidth' -l loss -x -d 'lost packets of links that state none'
__mlccactl_option 'bandwidth' -l limit -x -d "of the medium's time that may be taken"
__mlccactl_option 'bandwidth' -l background -x -d "of the medium's time that others take"
__mlccactl_option 'bandwidth' -l domain -x -a 'single-domain 1-hop 2-hop 3-hop' -d 'which links share the medium'
__mlccactl_option 'bandwidth' -l demand -x -d 'does this much fit?'

__mlccactl_option 'analyse-bus import' -l bitrate -x -d 'of the bus'
__mlccactl_option 'analyse-bus import' -l data-bitrate -x -d 'of the data phase of FD frames'
__mlccactl_option 'analyse-bus' -l network -x -d 'only this CAN network'
__mlccactl_option 'analyse-bus' -l unknown-senders -d 'other nodes may send'
__mlccactl_option 'analyse-bus' -l background-load -x -d 'share of the bus that others take'
__mlccactl_option 'analyse-bus' -l faults -x -d 'errors on the bus within the interval'
__mlccactl_option 'analyse-bus' -l fault-interval-ms -x -d 'see --faults'
__mlccactl_option 'analyse-bus' -l assign -d 'search for an order of the identifiers'
__mlccactl_option 'check' -l format -x -a 'text json sarif html' -d 'form of the report'
__mlccactl_option 'check export import learn' -l output -r -F -d 'write to this file'
__mlccactl_option 'check export format' -l force -d 'replace a file that exists'
__mlccactl_option 'check' -l watch -d 'check again whenever one of the files is saved'

__mlccactl_option 'describe' -l channel -x -d 'name or subject, where the file has several'
__mlccactl_option 'describe' -l subject -x -d '0x and up to 16 hexadecimal digits'
__mlccactl_option 'describe' -l random-subject -d 'a random subject'
__mlccactl_option 'describe' -l name -x -d 'short name'
__mlccactl_option 'describe' -l description -x -d 'one line for people'
__mlccactl_option 'describe' -l safe-side -x -a 'drop deliver none' -d 'when events are lost'
__mlccactl_option 'describe' -l set -x -a '$__mlccactl_attributes=' -d 'an attribute'
__mlccactl_option 'describe' -l set-user -x -d 'an attribute of your own'
__mlccactl_option 'describe' -l unset -x -a '$__mlccactl_attributes' -d 'remove an attribute'
__mlccactl_option 'describe' -l priority -x -d 'the attribute set that the options behind it are for'
__mlccactl_option 'describe' -l remove-set -x -d 'remove the attribute set of that priority'
__mlccactl_option 'describe new' -l dry-run -d 'print the result instead of writing it'

__mlccactl_option 'export' -l format -x -a 'dbc wireshark can-gw em_canid' -d 'for which tool'
__mlccactl_option 'export' -l network -x -d 'of dbc'
__mlccactl_option 'export' -l gateway -x -d 'of can-gw and em_canid'
__mlccactl_option 'format' -l short -d 'as XML attributes'
__mlccactl_option 'format' -l paper -d 'as elements'
__mlccactl_option 'format' -l in-place -d 'replace the file'
__mlccactl_option 'format' -s o -l output -r -F -d 'write to this file'
__mlccactl_option 'generate' -l component -x -d 'only this component'
__mlccactl_option 'generate' -l out -x -a '(__fish_complete_directories)' -d 'folder for what is generated'
__mlccactl_option 'generate' -l force -d 'overwrite files of others'

__mlccactl_option 'learn' -l for -x -d 'how long to listen'
__mlccactl_option 'learn' -l merge -x -a '(__mlccactl_files xml)' -d 'what would have to change in this'
__mlccactl_option 'learn' -l profile -x -a '(__mlccactl_of_interface (__mlccactl_profiles))' -d 'the profile of an interface'
__mlccactl_option 'learn' -l bitrate -x -a '(__mlccactl_of_interface)' -d 'the bit rate of an interface'
__mlccactl_option 'learn' -l data-bitrate -x -a '(__mlccactl_of_interface)' -d 'the same of its FD data phase'
__mlccactl_option 'learn' -l user -x -a '(__fish_complete_users)' -d 'user of programs here that send'
__mlccactl_option 'learn' -l no-local -d 'no program on this gateway receives anything'
__mlccactl_option 'learn import new' -l name -x -d 'name of the system'
__mlccactl_option 'learn import new' -l gateway -x -d 'name of the gateway'

__mlccactl_option 'import' -l format -x -a 'dbc eds cyphal dds-xml ros2-params ros2-topics' -d 'of the files'
__mlccactl_option 'import new' -l network -x -d 'of a network'
__mlccactl_option 'import' -l interface -x -a '(__mlccactl_can)' -d 'of that gateway, once for each network'
__mlccactl_option 'import' -l profile -x -a 'raw j1939' -d 'of a DBC file'
__mlccactl_option 'import' -l node -x -d 'of a CANopen or Cyphal file that states none'
__mlccactl_option 'import' -l default-period -x -d 'where the file states no cycle time'
__mlccactl_option 'new' -l channel -x -d 'a channel and what it needs'

__mlccactl_option 'rollout' -l off -x -a '(__mlccactl_places)' -d 'a gateway that is off'
__mlccactl_option 'rollout' -l wait -x -d 'how long it is followed'
__mlccactl_option 'rollout' -l back -d 'the description before the one that is in force'
__mlccactl_option 'rollout' -l accept -d 'take up the one that is in force in the cluster'
__mlccactl_option 'rollout' -l force -d 'although check finds errors, or grants would be lost'
__mlccactl_option 'rollout' -l cancel -d 'give up the one that is being rolled out'

__mlccactl_option 'doctor' -l can -x -a '(__mlccactl_can)' -d 'the interface'
__mlccactl_option 'doctor' -l send -d 'send frames on the bus'
__mlccactl_option 'doctor' -l id -x -d 'identifier of these frames'
__mlccactl_option 'doctor' -l fifo-depth -x -d 'what the description says of it'
__mlccactl_option 'doctor' -l bus-off -x -d 'wait so long for a person who shorts CAN_H and CAN_L'
__mlccactl_option 'doctor' -l bpf-root -x -a '(__fish_complete_directories)' -d 'where mlccad pins its gates'

complete -c mlccactl -n '__mlccactl_verb check describe export format generate new rollout' -a '(__mlccactl_files xml)'
complete -c mlccactl -n '__mlccactl_verb analyse-bus' -a '(__mlccactl_files xml csv)'
complete -c mlccactl -n '__mlccactl_verb import' -a '(__mlccactl_files dbc eds dcf yaml yml json txt xml)'
complete -c mlccactl -n '__mlccactl_verb learn' -a '(__mlccactl_learnable)'
complete -c mlccactl -n '__mlccactl_verb learn' -F
