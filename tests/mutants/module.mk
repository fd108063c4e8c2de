# SPDX-License-Identifier: BSD-2-Clause
# Of each folder COUNT= mutations, others with another SEED=, until SECONDS= are over. FOLDERS="core/can bpf"
# names folders, SCRATCH= keeps the copy of the tree.
mutants: ## whether the tests see a wrong program, by changes at random (root; COUNT= SEED= SECONDS= FOLDERS=)
	$(Q)CXX='$(CXX)' CLANG='$(CLANG)' tests/mutants/run
.PHONY: mutants
