# SPDX-License-Identifier: BSD-2-Clause
# Fuzzing with libFuzzer, AddressSanitizer and UBSan. A target is tests/fuzz/NAME.cc and one line here:
#
#   $(eval $(call fuzz_target,NAME,ARCHIVES,CORPUS,MAX_LEN,LIBS))
#
# ARCHIVES: archives of this tree (base relay client core control description enforce sources untrusted
# daemon cluster clusterlink clustercodec tools design learn), built once with instrumentation for
# all targets. A name with a slash is a further source (tests/tools/sources/proto_emulated).
# CORPUS: folders below tests/corpus. Their inputs are replayed completely, whatever MAX_LEN is.
#
# `make check-fuzz` replays every corpus and then fuzzes each target for FUZZ_SECONDS=10. `make
# fuzz` does so for FUZZ_SECONDS=3600, with a corpus that grows below $O/fuzz/corpus. FUZZ="a b"
# selects targets.
FUZZ_CXX ?= $(filter %ccache,$(firstword $(CXX))) clang++-19
FUZZ_FLAGS := -std=c++23 -Wno-deprecated-declarations -gline-tables-only -fno-omit-frame-pointer
# The optimisation of instrumented code. Tests that are built from the same objects are not
# instrumented, which saves half of the time. -O0 halves the time of the compiler, and the number of
# inputs per second: `make test` uses it (Makefile).
FUZZ_OPT ?= -O1
FUZZ_INTO := $(FUZZ_OPT) -fsanitize=fuzzer-no-link
FUZZ_SANITIZERS := address,undefined -fno-sanitize-recover=all
FUZZERS :=
FUZZ_OBJECTS :=

# g++ compiles the objects of each folder with different flags; here all objects get all of them.
$O/fuzz/obj/%.o: CPPFLAGS += $(XML_CFLAGS) $(NL_CFLAGS)
$(addprefix $O/fuzz/obj/,tools/%.o bundle/tools/%.o bundle/design/%.o bundle/doctor/%.o bundle/learn/%.o): CPPFLAGS += $(TOOLS_CPPFLAGS)
$O/fuzz/obj/tests/%.o $O/fuzz/obj/bundle/tests/%.o: FUZZ_INTO := -O0
$O/fuzz/obj/bundle/tests/%.o: CPPFLAGS += $(TOOLS_CPPFLAGS)
$O/fuzz/obj/tests/fuzz/%.o: FUZZ_FLAGS += $(WARN)
$O/fuzz/obj/tests/fuzz/%.o: FUZZ_INTO := $(FUZZ_OPT) -fsanitize=fuzzer-no-link
$O/fuzz/obj/%.o: %.cc | $(BPF_SKELETONS) $(BPF_TEST_SKELETONS) $(CONTROL_HEADERS) $(DESCRIPTION_TABLES) $(PROTOBUF_HEADERS)
	$(call say,FUZZCXX,$<)
	$(Q)mkdir -p $(@D) && $(FUZZ_CXX) $(FUZZ_FLAGS) $(FUZZ_INTO) -fsanitize=$(FUZZ_SANITIZERS) \
		$(CPPFLAGS) -MMD -MP -c $< -o $@
$O/fuzz/obj/bundle/%.o: $O/bundle/%.cc | $(BPF_SKELETONS) $(BPF_TEST_SKELETONS) $(CONTROL_HEADERS) $(DESCRIPTION_TABLES) $(PROTOBUF_HEADERS)
	$(call say,FUZZCXX,$(patsubst $O/bundle/%.cc,%,$<))
	$(Q)mkdir -p $(@D) && $(FUZZ_CXX) $(FUZZ_FLAGS) $(FUZZ_INTO) -fsanitize=$(FUZZ_SANITIZERS) \
		$(CPPFLAGS) -MMD -MP -c $< -o $@
$O/fuzz/obj/gen/%.pb.o: $O/gen/%.pb.cc
	$(call say,FUZZCXX,$<)
	$(Q)mkdir -p $(@D) && $(FUZZ_CXX) $(FUZZ_FLAGS) $(FUZZ_INTO) -fsanitize=$(FUZZ_SANITIZERS) -w \
		$(CPPFLAGS) -MMD -MP -c $< -o $@

# $(call fuzz_library,NAME,MORE OBJECTS)
define fuzz_library
$O/fuzz/lib$1.a: $(patsubst $O/%.o,$O/fuzz/obj/%.o,$($1_objects) $2)
	$$(call say,AR,$$@)
	$$(Q)rm -f $$@ && ar rcs $$@ $$^
FUZZ_OBJECTS += $(patsubst $O/%.o,$O/fuzz/obj/%.o,$($1_objects) $2)
endef
$(foreach library,base relay client core control description enforce sources untrusted daemon cluster clusterlink clustercodec tools design learn doctor,$(eval $(call fuzz_library,$(library))))

define fuzz_target
FUZZERS += $1
FUZZ_OBJECTS += $O/fuzz/obj/tests/fuzz/$1.o $(foreach part,$2,$(if $(findstring /,$(part)),$O/fuzz/obj/$(part).o))
$O/fuzz/$1: $O/fuzz/obj/tests/fuzz/$1.o \
		$(foreach part,$2,$(if $(findstring /,$(part)),$O/fuzz/obj/$(part).o,$O/fuzz/lib$(part).a))
	$$(call say,LINK,$$@)
	$$(Q)$$(FUZZ_CXX) -fsanitize=fuzzer,$$(FUZZ_SANITIZERS) -o $$@ $$^ $5
check-fuzz-$1: $O/fuzz/$1
	$$(Q)tests/fuzz/run --seconds $$(or $$(FUZZ_SECONDS),10) --max-len $4 $O $1 $(addprefix tests/corpus/,$3)
fuzz-$1: $O/fuzz/$1
	$$(Q)tests/fuzz/run --keep --seconds $$(or $$(FUZZ_SECONDS),3600) --max-len $4 $O $1 \
		$(addprefix tests/corpus/,$3)
.PHONY: check-fuzz-$1 fuzz-$1
endef

$(eval $(call fuzz_target,der_fuzz,,der,1500))
$(eval $(call fuzz_target,afp_fuzz,relay control,afp,600,-lfmt))
$(eval $(call fuzz_target,j1939_fuzz,relay control,j1939,4096,-lfmt))
$(eval $(call fuzz_target,famouso_fuzz,relay client relay control,famouso,1024,-lfmt))
$(eval $(call fuzz_target,layers_fuzz,relay control,layers,1024,-lfmt))
FORMAT_OBJECTS := $(addprefix tools/,$(addprefix design/,format/rewrite describe/lists describe/layout describe/markup \
	describe/quantity) escape values table)
$(eval $(call fuzz_target,description_fuzz,$(FORMAT_OBJECTS) description control core,description/good description/bad,16384,$(XML_LIBS) -lfmt))
$(eval $(call fuzz_target,journal_fuzz,$(addprefix daemon/store/,oneofs journal format contents disk) tests/daemon/store/fake_disk control core,journal,2048,))
$(eval $(call fuzz_target,replies_fuzz,$(addprefix tools/,$(basename $(notdir $(wildcard tools/render*.cc))) json audit audit_additions elements escape table words values times) control core,replies,4096,))
$(eval $(call fuzz_target,tables_fuzz,tools/design/analyse_bus/table tools/design/analyse_bus/distinct tools/values core,tables,2048,))
$(eval $(call fuzz_target,recordings_fuzz,learn relay tools/elements tools/escape tools/table description control core,recordings,8192,$(XML_LIBS) -lz -lfmt))
$(eval $(call fuzz_target,import_fuzz,$(basename $(wildcard tools/design/import/*.cc)) $(addprefix tools/,design/attribute_list elements escape table values) description control core,import,4096,$(XML_LIBS) $(YAML_LIBS) -lfmt))
$(eval $(call fuzz_target,sources_texts_fuzz,untrusted sources core base,sources_texts,16384,$(NL_LIBS) -lsystemd))
$(eval $(call fuzz_target,sources_packets_fuzz,untrusted sources core base,sources_packets,16384,$(NL_LIBS) -lsystemd))
$(eval $(call fuzz_target,netlink_fuzz,daemon sources core base,netlink,2048,$(NL_LIBS) -lsystemd -lfmt))
$(eval $(call fuzz_target,cluster_wire_fuzz,daemon/cluster/wire,cluster_wire,4096,))
$(eval $(call fuzz_target,cluster_entries_fuzz,clustercodec control core,cluster_entries,4096,-lfmt))
$(eval $(call fuzz_target,cluster_grpc_fuzz,$(addprefix cluster/,etcd grpc outcome),cluster_grpc,2048,))
# The complete gateway, with gates in the kernel. Needs root.
$(eval $(call fuzz_target,control_fuzz,$(addprefix tests/,fuzz/gateway_under_test fuzz/surroundings daemon/gates/sandbox) tools/readback/differences daemon clustercodec clusterlink sources enforce control description core base,control,2048,$(DAEMON_LIBS)))

FUZZ ?= $(FUZZERS)
check-fuzz: $(addprefix check-fuzz-,$(FUZZ)) ## what comes from outside: stored corpus, then FUZZ_SECONDS=10 of mutations each
fuzz: $(addprefix fuzz-,$(FUZZ)) ## the same for FUZZ_SECONDS=3600 each, corpus kept below $O/fuzz (FUZZ="NAMES")
.PHONY: check-fuzz fuzz

-include $(FUZZ_OBJECTS:.o=.d)
