# SPDX-License-Identifier: BSD-2-Clause
# Makes COUNT= mutations in each folder, different ones with another SEED=, until SECONDS= have
# passed. FOLDERS="core/can bpf" selects folders, SCRATCH= keeps the copy of the tree.
mutants: ## whether the tests see a wrong program, by changes at random (root; COUNT= SEED= SECONDS= FOLDERS=)
	$(Q)CXX='$(CXX)' CLANG='$(CLANG)' tests/mutants/run
.PHONY: mutants
