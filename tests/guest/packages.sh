# SPDX-License-Identifier: BSD-2-Clause
# For guest tests of the packages (bash, under systemd): . tests/guest/packages.sh
#
# The guest has no network and no list of packages: what a package of ours depends on must be installed on the host,
# whose root the guest has. Of the host's other packages dpkg does not know there. apt takes ours from $packages/now
# and $packages/next (build-packages).
. "$(dirname "${BASH_SOURCE[0]}")/gateway.sh"
packages=$BUILD/packages
export DEBIAN_FRONTEND=noninteractive

# debian_as_installed: what the host's root has of the container that it may be is taken away: rules of dpkg and apt,
# and a policy by which no package may start or stop a service.
debian_as_installed() {
	rm -rf /usr/sbin/policy-rc.d /etc/apt/sources.list /etc/apt/sources.list.d/* /etc/apt/apt.conf.d/* \
		/etc/dpkg/dpkg.cfg.d/* /var/lib/apt/lists/* /var/lib/apt/extended_states
	mount -t tmpfs tmpfs /var/lib/dpkg && cp -a "$packages/dpkg/." /var/lib/dpkg/ || fail "the database of dpkg"
	! dpkg-query -W 'mlcca*' 'libmlcca*' 2>/dev/null | grep . || fail "there are packages of ours before the first command"
	! command -v mlccad mlccactl || fail "there are programs of ours before the first command"
}

# apt_log COMMAND...: with what it says in /run/apt.
apt_log() {
	"$@" >/run/apt 2>&1 || fail "$*: $(cat /run/apt)"
}

# version_of PACKAGE: of the one that is installed; nothing where none is.
version_of() {
	dpkg-query -W -f '${db:Status-Status} ${Version}' "$1" 2>/dev/null | sed -n 's/^installed //p'
}
