# SPDX-License-Identifier: BSD-2-Clause
# COUNT= mutations of each folder, SEED=, SECONDS=, FOLDERS="core/can bpf", SCRATCH=: tests/mutants/run.
mutants: ## whether the tests see a wrong program: single changes at random (root; COUNT= SEED= SECONDS= FOLDERS=)
	$(Q)CXX='$(CXX)' CLANG='$(CLANG)' tests/mutants/run
.PHONY: mutants
