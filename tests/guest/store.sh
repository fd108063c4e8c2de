# SPDX-License-Identifier: BSD-2-Clause
# For guest tests (bash): an etcd on the loopback, with TLS, and what mlcca-cluster needs to reach it.

# start_store [MEMBERS [USER...]]: of one member, unless stated, at the port 2379; each further one is 10000 higher. There
# are certificates of root, of gw1, which /etc/mlcca/cluster has as well, and of the users. Sets $etcd to the processes and
# $store_endpoints. The folder of the script is /run/store from then on.
start_store() {
	local members=${1:-1} name number peers=() addresses=()
	umask 077
	mkdir -p /run/store /etc/mlcca/cluster && cd /run/store || fail "folders"
	{
		openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=authority \
			-keyout ca.key -out ca.pem
		for name in server root gw1 "${@:2}"; do
			openssl req -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj /CN=$name -keyout $name.key \
				-out $name.csr
			echo 'subjectAltName=IP:127.0.0.1' >ext
			openssl x509 -req -in $name.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile ext -out $name.pem
		done
	} 2>/dev/null || fail "certificates"
	ip link set lo up
	for ((number = 0; number < members; number++)); do
		peers+=("member$number=http://127.0.0.1:$((2380 + 10000 * number))")
		addresses+=("https://127.0.0.1:$((2379 + 10000 * number))")
	done
	store_peers=$(IFS=,; echo "${peers[*]}")
	store_endpoints=$(IFS=,; echo "${addresses[*]}")
	etcd=()
	for ((number = 0; number < members; number++)); do
		start_member $number
	done
	cp ca.pem /etc/mlcca/cluster/ca.pem && cp gw1.pem /etc/mlcca/cluster/cert.pem &&
		cp gw1.key /etc/mlcca/cluster/key.pem
	printf 'endpoint = %s\n' "${addresses[@]}" >/etc/mlcca/cluster.conf
	chmod 644 /etc/mlcca/cluster.conf
}

# start_member NUMBER: of the ones of start_store, again after it has ended
start_member() {
	local client=https://127.0.0.1:$((2379 + 10000 * $1)) peer=http://127.0.0.1:$((2380 + 10000 * $1))
	etcd --name member$1 --data-dir data$1 --listen-client-urls $client --advertise-client-urls $client \
		--listen-peer-urls $peer --initial-advertise-peer-urls $peer --initial-cluster "$store_peers" \
		--cert-file server.pem --key-file server.key --client-cert-auth --trusted-ca-file ca.pem --bcrypt-cost 4 \
		--logger zap --log-level error >>etcd.log 2>&1 &
	etcd[$1]=$!
}

# store WORD...: etcdctl of root
store() {
	ETCDCTL_API=3 etcdctl --cacert=ca.pem --cert=root.pem --key=root.key --endpoints="$store_endpoints" \
		--dial-timeout=60s --command-timeout=60s "$@"
}

# with_roles SYSTEM NETWORK GATEWAY...: users and roles as docs/how-to/cluster-etcd.md has them, and the first gateway may
# roll out. From then on nobody has a right that is not granted.
with_roles() {
	local system=$1 network=$2 name prefix
	wait_for 60 store endpoint health
	{
		store user add root --no-password && store user grant-role root root
		for name in "${@:3}"; do
			store role add $name
			store role grant-permission $name --prefix=true read /mlcca/$system/
			store role grant-permission $name readwrite /mlcca/$system/m/$name
			store role grant-permission $name readwrite /mlcca/$system/d/vote/$name
			for prefix in x/$name/ a/$name/ r/$network/$name/ f/ v/; do
				store role grant-permission $name --prefix=true readwrite /mlcca/$system/$prefix
			done
			store user add $name --no-password && store user grant-role $name $name
		done
		store role grant-permission $3 --prefix=true readwrite /mlcca/$system/d/
		store auth enable
	} >roles.log 2>&1 || fail "roles: $(cat roles.log)"
}
