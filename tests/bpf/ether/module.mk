$(patsubst %.cc,$O/%.o,$(wildcard tests/bpf/ether/*.cc)): $(BPF_SKELETONS) $(BPF_TEST_SKELETONS)
$(eval $(call kernel_test,ether_frames_test,$(addprefix tests/bpf/ether/,frames_test.cc fragments_test.cc random_test.cc wpan_test.cc watch_test.cc senders_test.cc generation_test.cc can_twin.cc oracle.cc packets.cc loaded_ether.cc memory_test.cc),$O/libenforce.a,-lbpf -lfmt -lpthread))
$(eval $(call kernel_test,ether_sockets_test,$(addprefix tests/bpf/ether/,sockets_test.cc silence_test.cc readback_test.cc packets.cc),$O/libenforce.a,-lbpf -lfmt))
