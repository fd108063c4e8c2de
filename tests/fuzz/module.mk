# SPDX-License-Identifier: BSD-2-Clause
# Fuzzing with libFuzzer. check-fuzz is short and repeatable: the stored corpus and FUZZ_RUNS
# mutations from a fixed seed. `make fuzz` goes on from there with a corpus that grows below $O.
FUZZ_CXX ?= clang++-19
FUZZ_RUNS ?= 300000
FUZZ_SECONDS ?= 600
FUZZ_FLAGS := -std=c++23 -O1 -g -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all -Iinclude -I.
FUZZ_CORPUS := tests/corpus/der
FUZZERS := $O/fuzz/der_fuzz

$O/fuzz/%: tests/fuzz/%.cc $(wildcard include/mlcca/*.hpp)
	$(call say,FUZZ,$<)
	$(Q)mkdir -p $(@D) && $(FUZZ_CXX) $(FUZZ_FLAGS) $(WARN) $< -o $@

check-fuzz: $(FUZZERS) ## the readers of foreign octets: corpus and a bounded number of mutations
	$(Q)rm -rf $O/fuzz/short && mkdir -p $O/fuzz/short
	$(Q)$O/fuzz/der_fuzz -seed=1 -runs=$(FUZZ_RUNS) -max_len=1500 -artifact_prefix=$O/fuzz/ \
		$O/fuzz/short $(FUZZ_CORPUS) >$O/fuzz/der_fuzz.log 2>&1 || { tail -n 40 $O/fuzz/der_fuzz.log; exit 1; }
	@echo "  PASS    der_fuzz: $(words $(wildcard $(FUZZ_CORPUS)/*)) files and $(FUZZ_RUNS) mutations"

fuzz: $(FUZZERS) ## the same without an end (FUZZ_SECONDS=600), corpus below $O/fuzz
	$(Q)mkdir -p $O/fuzz/corpus
	$O/fuzz/der_fuzz -max_len=1500 -max_total_time=$(FUZZ_SECONDS) -print_final_stats=1 \
		-artifact_prefix=$O/fuzz/ $O/fuzz/corpus $(FUZZ_CORPUS)
.PHONY: check-fuzz fuzz
