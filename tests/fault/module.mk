# SPDX-License-Identifier: BSD-2-Clause
# A library for LD_PRELOAD which lets the n-th call fail, or kills the process in it (nth_call.h).
$O/tests/nth_call.so: tests/fault/nth_call.c tests/fault/nth_call.h
	$(call say,CC,$@)
	$(Q)mkdir -p $(@D) && $(CC) -std=gnu17 -O1 -fPIC -shared $(filter-out -Wpedantic,$(WARN)) -o $@ $<

# Runs mlccad on real devices while each call of a class fails in turn: a sample of them, or all.
FAULT_SAMPLE ?= 34
FAULT_SEED ?= 1
FAULT_NEEDS := $O/tests/nth_call.so $O/mlccad $O/mlcca-awds $O/mlccactl $O/mlcca-readback
check-fault: $(FAULT_NEEDS) ## mlccad while the n-th call fails, a sample of all (root)
	$(Q)tests/fault/nth-call $O --sample $(FAULT_SAMPLE) --seed $(FAULT_SEED)
	$(Q)tests/fault/reload-memory $O 32 $(FAULT_SEED)
soak-fault: stage $(GUEST_READY) $(FAULT_NEEDS) ## the same for every call; of those that allocate every tenth: hours (root)
	$(Q)tests/fault/nth-call $O --most 1000 --patience 5
	$(Q)$(SOAK_GUEST) SAMPLE=0 tests/guest/cases/nth-call
	$(Q)tests/fault/reload-memory $O
check-memory: $(FAULT_NEEDS) ## mlccad at the limit of its memory, in a cgroup (root)
	$(call say,TEST,a limit of memory)
	$(Q)tests/fault/memory-limit $O
.PHONY: check-fault soak-fault check-memory
