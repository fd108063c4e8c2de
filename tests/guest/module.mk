# SPDX-License-Identifier: BSD-2-Clause
# Tests on Debian's kernel in QEMU, each in a separate guest. GUEST_TESTS are run by init,
# GUEST_SYSTEMD_TESTS as a service of systemd. What they need is a prerequisite of check-guest. The
# longest ones run first, so that no processor has to wait for one of them at the end.
GUEST_TESTS :=
GUEST_SYSTEMD_TESTS :=
GUEST_LONGEST = $(addprefix tests/guest/cases/,kills nth-call subscriptions-travel)
# A case waits a third of its time: for timers, and for what it has started.
GUEST_JOBS ?= $(WAITING_JOBS)
GUEST_READY := $O/guest/ready

$(GUEST_READY): tests/guest/build-image tests/guest/extract-vmlinux tests/guest/init
	$(call say,GUEST,$(@D))
	$(Q)tests/guest/build-image $(@D) && touch $@

guest-image: $(GUEST_READY) ## Debian's kernel and an initramfs for the guest

check-guest: all $(GUEST_READY) $O/tests/nth_call.so $O/tests/speak ## the product on real SocketCAN and systemd, in QEMU
	$(Q)for case in $(filter-out $(GUEST_TESTS) $(GUEST_SYSTEMD_TESTS),$(wildcard tests/guest/cases/*)); do \
		echo "$$case is in no list of guest tests"; exit 1; done
	$(Q)BUILD=$(abspath $O) GUEST_IMAGE=$(abspath $O)/guest tests/guest/run-tests -j $(GUEST_JOBS) \
		$O/guest/log --systemd $(GUEST_SYSTEMD_TESTS) --init $(GUEST_LONGEST) \
		$(filter-out $(GUEST_LONGEST),$(GUEST_TESTS))

# Packages of what is already built; nothing is compiled for them. Their pages may be older than
# those of the tree.
PACKAGES_READY := $O/packages/ready
$(PACKAGES_READY): tests/guest/build-packages tests/guest/dpkg-database $(wildcard debian/* systemd/*) $(PROGRAMS) $(MADE_PAGES)
	$(call say,DEB,$(@D))
	$(Q)BUNDLE=$(BUNDLE) tests/guest/build-packages $O $(@D) && touch $@

packages: $(PACKAGES_READY) ## the packages for the guest, of what is built

# These packages are not compressed, because each is read once.
check-lintian: $(PACKAGES_READY) ## what lintian says of the packages
	$(call say,LINTIAN,$(<D))
	$(Q)lintian --no-cfg --allow-root --fail-on error,warning \
		--suppress-tags uses-no-compression-for-control-tarball,uses-no-compression-for-data-tarball $(<D)/now/*.deb

check-harness: $(GUEST_READY) ## the guest harness itself
	$(Q)GUEST_IMAGE=$(abspath $O)/guest tests/guest/selftest

.PHONY: guest-image packages check-guest check-harness check-lintian

GUEST_TESTS += $(addprefix tests/guest/cases/,nth-call ethernet-gate ethernet-publishers doctor attach-drift)
GUEST_TESTS += $(addprefix tests/guest/cases/,emergency-stop frame-forms daemon-dies interfaces-change logger-case managed-interface same-identifier same-subject profile-change learn learn-recording audit-report)
GUEST_TESTS += $(addprefix tests/guest/cases/,mesh-nl80211 mesh-batman mesh-case-study mesh-relay-gate rover)
GUEST_TESTS += $(addprefix tests/guest/cases/,bus-queue gateways-in-namespaces reservations unlisted-channels)
GUEST_TESTS += $(addprefix tests/guest/cases/,babbling-node missing-events can-profiles forwarding j1939-messages)
GUEST_TESTS += $(addprefix tests/guest/cases/,altered-slots famouso-tags famouso-claims famouso-broker relay relay-parallel relay-ring gateway-fails gateways-on-a-bus gateways-on-a-shared-bus relay-wpan relay-awds subscriptions-travel subscriptions-radio)
GUEST_SYSTEMD_TESTS += $(addprefix tests/guest/cases/,newcomer package-life service-life documents package-test plugged-in awds-unit cluster-unit switched-off famouso-unit)
check-guest: stage $(PACKAGES_READY)
