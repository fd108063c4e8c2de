# The skeletons are prerequisites by hand: -MMD leaves out what -isystem finds.
$(patsubst %.cc,$O/%.o,$(wildcard tests/bpf/*.cc)): $(BPF_SKELETONS) $(BPF_TEST_SKELETONS)
$(eval $(call kernel_test,gate_frames_test,$(wildcard tests/bpf/*.cc),$O/libenforce.a $O/libcore.a,-lbpf -lfmt -lpthread))
