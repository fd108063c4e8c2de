# SPDX-License-Identifier: BSD-2-Clause
# For guest tests (bash): an etcd of one member on the loopback, with TLS, and what mlcca-cluster needs to reach it as gw1.
# Sets $etcd. The folder of the script is /run/store from then on.
start_store() {
	umask 077
	mkdir -p /run/store /etc/mlcca/cluster && cd /run/store || fail "folders"
	{
		openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=authority \
			-keyout ca.key -out ca.pem
		for name in server gw1; do
			openssl req -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj /CN=$name -keyout $name.key \
				-out $name.csr
			echo 'subjectAltName=IP:127.0.0.1' >ext
			openssl x509 -req -in $name.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile ext -out $name.pem
		done
	} 2>/dev/null || fail "certificates"
	ip link set lo up
	etcd --data-dir data --listen-client-urls https://127.0.0.1:2379 --advertise-client-urls https://127.0.0.1:2379 \
		--listen-peer-urls http://127.0.0.1:2380 --cert-file server.pem --key-file server.key --client-cert-auth \
		--trusted-ca-file ca.pem --logger zap --log-level error >etcd.log 2>&1 &
	etcd=$!
	cp ca.pem /etc/mlcca/cluster/ca.pem && cp gw1.pem /etc/mlcca/cluster/cert.pem &&
		cp gw1.key /etc/mlcca/cluster/key.pem
	echo 'endpoint = https://127.0.0.1' >/etc/mlcca/cluster.conf
	chmod 644 /etc/mlcca/cluster.conf
}
