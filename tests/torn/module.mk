# SPDX-License-Identifier: BSD-2-Clause
# Numbered traffic while the daemon is killed and its surroundings are taken away (see harness.py).
# CI runs a fixed sample (CI_SEED) of this random test, `make soak` as much as ROUNDS and KILLS say.
$(eval $(call program,tests/traffic,tests/torn/traffic.cc,,-lfmt -lpthread))
TORN_READY := $O/tests/traffic $O/tests/nth_call.so
CI_SEED ?= 1
KILLS ?= 1000
ROUNDS ?= 200
export CI_SEED

GUEST_TESTS += $(addprefix tests/guest/cases/,kills torn)
check-guest: $(TORN_READY)

check-torn: all $O/tests/traffic ## what mlccad lives on is taken away, on this kernel: root
	$(Q)BUILD=$(abspath $O) SEED=$(CI_SEED) ROUNDS=8 SPAN=40 tests/torn/run

SOAK_GUEST = BUILD=$(abspath $O) tests/guest/run --image $(abspath $O)/guest --smp 2 --memory 1024 --timeout 36000 -- \
	env BUILD=$(abspath $O) SEED=$(SEED)
soak-kills: stage $(GUEST_READY) $(TORN_READY)
	$(Q)$(SOAK_GUEST) KILLS=$(KILLS) tests/guest/cases/kills
soak-torn: stage $(GUEST_READY) $(TORN_READY)
	$(Q)BUILD=$(abspath $O) SEED=$(SEED) ROUNDS=$(ROUNDS) tests/torn/run
	$(Q)$(SOAK_GUEST) ROUNDS=$(ROUNDS) tests/guest/cases/torn
.PHONY: check-torn soak-kills soak-torn
