# The skeletons are stated as prerequisites, because -MMD leaves out headers found by -isystem.
$(patsubst %.cc,$O/%.o,$(wildcard tests/bpf/*.cc)): $(BPF_SKELETONS) $(BPF_TEST_SKELETONS)
$(eval $(call kernel_test,gate_frames_test,$(wildcard tests/bpf/*.cc),$O/libenforce.a $O/libcore.a,-lbpf -lfmt -lpthread))
