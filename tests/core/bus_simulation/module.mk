# SPDX-License-Identifier: BSD-2-Clause
# Compares a simulated bus with the analysis, for 100,000 sets of messages or the number in SETS.
$(eval $(call unit_test,bus_sim_test,$(wildcard tests/core/bus_simulation/*.cc),$O/libcore.a,))
BUS_SETS ?= 10000000
soak-bus: $O/tests/bus_sim_test
	$(Q)SETS=$(BUS_SETS) SEED=$(or $(SEED),1) $<
.PHONY: soak-bus
