# Each bench prints its ratios to a named baseline that it measures in the same run. Needs root.
BENCHES ?=

$(eval $(call program,bench/gate_bench,tests/bench/gate_bench.cc tests/bpf/loaded_gate.cc,$O/libenforce.a,-lbpf -lfmt))
$O/tests/bench/gate_bench.o: $(BPF_SKELETONS) $(BPF_TEST_SKELETONS)
BENCHES += $O/bench/gate_bench

$(eval $(call program,bench/ether_bench,tests/bench/ether_bench.cc tests/bpf/ether/loaded_ether.cc tests/bpf/ether/packets.cc,$O/libenforce.a,-lbpf -lfmt))
$O/bpf/shuffle.bpf.o: tests/bench/shuffle.bpf.c
	$(call say,BPF,$<)
	$(Q)mkdir -p $(@D) && $(CLANG) $(BPF_CFLAGS) -c $< -o $@ && $(LLVM_STRIP) -g $@
$O/tests/bench/ether_bench.o: $(BPF_SKELETONS) $(BPF_TEST_SKELETONS) $O/gen/shuffle.skel.h
BENCHES += $O/bench/ether_bench

$(eval $(call program,bench/admission_bench,tests/bench/admission_bench.cc,$O/libcore.a,-lbenchmark -lpthread))
$(eval $(call program,bench/socket_bench,tests/bench/socket_bench.cc,$O/libcontrol.a,-lfmt))
BENCHES += $O/bench/admission_bench $O/bench/socket_bench

$(eval $(call program,bench/reader_bench,tests/bench/reader_bench.cc,$O/libdescription.a $O/libcore.a,$(XML_LIBS) -lfmt))
$O/tests/bench/reader_bench.o: CPPFLAGS += $(XML_CFLAGS)
BENCHES += $O/bench/reader_bench

$(eval $(call program,bench/mesh_bench,tests/bench/mesh_bench.cc,$O/libcore.a,-lbenchmark -lpthread))
BENCHES += $O/bench/mesh_bench

$(eval $(call program,bench/journal_bench,tests/bench/journal_bench.cc,$(patsubst %.cc,$O/%.o,$(wildcard daemon/store/*.cc)) $O/libcontrol.a,-lsqlite3 -lfmt))
BENCHES += $O/bench/journal_bench

# The journal compared with SQLite, with its crash tests: a prototype on the fakes of
# tests/daemon/store.
$(eval $(call program,bench/store_bench,$(wildcard tests/bench/store/*.cc) $(addprefix tests/daemon/store/,fake_disk.cc worlds.cc),$(patsubst %.cc,$O/%.o,$(wildcard daemon/store/*.cc)) $O/libcontrol.a $O/libcore.a,-lsqlite3 -lfmt -lgtest -lpthread))
BENCHES += $O/bench/store_bench
run-bench-store: $O/bench/store_bench
	$(Q)$O/bench/store_bench $O/bench
.PHONY: run-bench-store

$(eval $(call program,bench/can_bench,tests/bench/can_bench.cc,$O/libcore.a,))
BENCHES += $O/bench/can_bench

$(eval $(call program,bench/reservation_bench,tests/bench/reservation_bench.cc,$O/libcore.a,-lfmt))
BENCHES += $O/bench/reservation_bench

# Cyclone DDS, the peer. Its own compiler generates the types.
$O/gen/bench/dds/pair.h: tests/bench/dds/pair.idl
	$(call say,IDLC,$<)
	$(Q)mkdir -p $(@D) && idlc -o $(@D) $<
$O/tests/bench/dds_peer.o: $O/gen/bench/dds/pair.h
$O/bench/dds_peer: $O/tests/bench/dds_peer.o
	$(call say,LINK,$@)
	$(Q)mkdir -p $(@D) && $(CC) -c -I$O/gen -o $O/gen/bench/dds/pair.o $O/gen/bench/dds/pair.c && \
		$(CXX) $(LDFLAGS) -o $@ $^ $O/gen/bench/dds/pair.o -lddsc
OBJECTS += $O/tests/bench/dds_peer.o
BENCHES += $O/bench/dds_peer

# Benches with real frames need CAN, so they run in the guest.
$(eval $(call program,bench/frames,tests/bench/frames/frames.cc,$O/libenforce.a,-lbpf -lfmt))
run-bench-frames: all $O/bench/frames $(GUEST_READY)
	$(Q)tests/bench/frames/run $O

run-bench: all $(BENCHES)
	$(Q)tests/bench/run $O
.PHONY: run-bench

$(eval $(call program,bench/start_bench,tests/bench/start_bench.cc tests/daemon/start/daemon.cc tests/daemon/gates/sandbox.cc,$O/libenforce.a,-lbpf -lfmt))
BENCHES += $O/bench/start_bench

# Events through mlcca-relay and between programs, each with a peer for comparison.
$(eval $(call program,bench/probe,tests/bench/relay/probe.cc,$O/libclient.a $O/librelay.a $O/libcontrol.a,-lfmt -lpthread))
BENCHES += $O/bench/probe
$(eval $(call program,bench/bus-probe,tests/bench/relay/bus_probe.cc,,-lpthread))
BENCHES += $O/bench/bus-probe
run-bench-relay: all $O/bench/probe $O/bench/bus-probe $(GUEST_READY)
	$(Q)tests/bench/relay/run $O
	$(Q)tests/bench/relay/run-bus $O
.PHONY: run-bench-relay

# The cost of learning from a log of MIB mebibytes, and from four live buses beside candump.
run-bench-learn: run-bench-learn-log all $O/bench/probe $(GUEST_READY)
	$(Q)tests/bench/learn/ethernet $O
	$(Q)tests/bench/learn/run $O
run-bench-learn-log: $O/mlccactl $O/mlcca-design
	$(Q)tests/bench/learn/log $O
.PHONY: run-bench-learn run-bench-learn-log

# The connection to the store of a cluster, compared with libcurl alone.
$(eval $(call program,bench/cluster_bench,tests/bench/cluster_bench.cc $(addprefix tests/cluster/,gateway.cc processes.cc store.cc),$(CLUSTER_ARCHIVES),$(CLUSTER_LIBS) -lfmt))
$O/bench/cluster_bench: | $O/mlcca-cluster
BENCHES += $O/bench/cluster_bench

# Several gateways on one store: an admission compared with its transaction, many gateways, and
# taking over.
$(eval $(call program,bench/gateways_bench,$(wildcard tests/bench/gateways/*.cc) $(addprefix tests/cluster/,gateway.cc processes.cc store.cc),$(CLUSTER_ARCHIVES) $O/libclustercodec.a $O/libcontrol.a $O/libdescription.a $O/libcore.a,$(CLUSTER_LIBS) $(XML_LIBS) -lfmt -lpthread))
$O/bench/gateways_bench: | $O/mlccad $O/mlcca-cluster $O/mlcca-relay
BENCHES += $O/bench/gateways_bench
run-bench-gateways: all $O/bench/gateways_bench
	$(Q)$O/bench/gateways_bench $O/bench
.PHONY: run-bench-gateways
