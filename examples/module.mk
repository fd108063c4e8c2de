# The stage has everything that a package would install, without debug information. The guest copies
# it over its root file system, which is in memory.
STAGE := $O/stage
stage: all
	$(Q)rm -rf $(STAGE) && $(MAKE) install DESTDIR=$(abspath $(STAGE)) PREFIX=/usr V=$V >/dev/null && \
		find $(STAGE) -type f -perm -100 -exec strip --strip-debug {} +

DEMO ?= guest
run-demo: run-demo-$(DEMO)
run-demo-guest: stage $(GUEST_READY)
	$(Q)GUEST_IMAGE=$(abspath $O)/guest tests/guest/run --systemd --smp 2 --timeout 900 -- \
		examples/volksbot/demo systemd $(abspath $(STAGE))
run-demo-host: all
	$(Q)unshare --net --mount sh -c 'mount -t tmpfs run /run && mkdir /run/netns && \
		exec examples/volksbot/demo plain $(abspath $O)'
.PHONY: stage run-demo run-demo-guest run-demo-host

EXAMPLES := $(foreach e,volksbot mesh rover wpan applications,$(wildcard examples/$e/*.xml examples/$e/*/*.xml examples/$e/*.md \
	examples/$e/*.py examples/$e/*.cc examples/$e/CMakeLists.txt)) examples/learn/short.log \
	examples/generated/Makefile
install-examples:
	$(call say,INSTALL,examples)
	$(Q)for file in $(EXAMPLES); do \
		install -D -m 644 $$file $(DESTDIR)$(PREFIX)/share/doc/mlcca/$$file || exit 1; \
	done
PARTS += install-examples
.PHONY: install-examples
