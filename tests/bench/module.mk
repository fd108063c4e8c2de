# Each bench prints its ratios to a named floor that it measures in the same run. Root.
BENCHES ?=

$(eval $(call program,bench/gate_bench,tests/bench/gate_bench.cc tests/bpf/loaded_gate.cc,$O/libenforce.a,-lbpf -lfmt))
$O/tests/bench/gate_bench.o: $(BPF_SKELETONS)
BENCHES += $O/bench/gate_bench
