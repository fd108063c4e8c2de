# SPDX-License-Identifier: BSD-2-Clause
# Installs what the tree needs: the Build-Depends of debian/control, and the kernel package for the
# guest. Until then, what make computes while it reads the fragments (pkg-config) is empty, so a
# target that must work on a bare machine starts make again:
#   test: ensure-deps
#   	$(Q)$(MAKE) test-all

# Prints one package name on each line: of alternatives the first one, without version, architecture
# and profile. build-essential is added, because Build-Depends need not state it; dh-sequence-… are
# left out, because they are parts of debhelper.
DEPS_LIST = { echo build-essential; awk '/^[^ \#]/ { on = sub(/^Build-Depends:/, "") } \
	on && !/^\#/ { gsub(/\([^)]*\)|<[^>]*>|\[[^]]*\]|\|[^,]*/, ""); gsub(/,/, "\n"); print }' \
	debian/control; } | sed 's/[[:space:]]//g; s/^debhelper-compat$$/debhelper/; /^dh-sequence-/d; /^$$/d'

ensure-deps:
	@packages=$$($(DEPS_LIST)); \
	installed=$$(dpkg-query -W -f '$${db:Status-Status} $${Package}\n' $$packages 2>/dev/null | \
		sed -n 's/^installed //p'); \
	missing=$$(printf '%s\n' $$packages | grep -vxF -e "$$installed"); \
	root() { if [ "$$(id -u)" = 0 ]; then "$$@"; else sudo "$$@"; fi; }; \
	update() { root apt-get -q update; }; \
	if [ -n "$$missing" ]; then \
		echo "installing:" $$missing; \
		update && root env DEBIAN_FRONTEND=noninteractive \
			apt-get -q install -y --no-install-recommends $$missing || exit 1; \
	fi; \
	ls $O/guest/linux-image-*.deb >/dev/null 2>&1 || \
		tests/guest/build-image --download $O/guest || \
		{ update && tests/guest/build-image --download $O/guest; }

deps: ensure-deps ## install what is missing (root or sudo), fetch the guest's kernel

.PHONY: ensure-deps deps
