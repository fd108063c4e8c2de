TEST_FOLDERS := $(sort $(dir $(wildcard tests/*/module.mk tests/*/*/module.mk tests/*/*/*/module.mk)))
# The files of a test program are compiled as one as well, if they can be. Only builds need their
# list.
TEST_BUNDLES := $(if $(BUNDLE),$(if $(filter run-demo install uninstall clean help,$(MAKECMDGOALS)),,$O/bundle/tests.mk))
-include $(TEST_BUNDLES)
include $(addsuffix module.mk,$(TEST_FOLDERS))
bundled_files := $(foreach name,$(BUNDLED_TESTS),$($(name)_bundled))
# Their names, which are written if they are others than before: the bundles change, too, when a file is gone.
ifneq ($(TEST_BUNDLES),)
ifneq ($(strip $(file <$O/bundle/tests.files)),$(strip $(bundled_files)))
$(shell mkdir -p $O/bundle)$(file >$O/bundle/tests.files,$(bundled_files))
endif
endif
$O/bundle/tests.mk: tests/support/bundle-tests $(bundled_files) $O/bundle/tests.files
	$(Q)mkdir -p $(@D) && $< $@ $(foreach name,$(BUNDLED_TESTS),$(name)= $($(name)_bundled))
TEST_OBJECTS := $(patsubst %.cc,$O/%.o,$(wildcard tests/*/*.cc tests/*/*/*.cc tests/*/*/*/*.cc))
# The tests are optimised less than the tested code, because they take most of the time of a build.
$(filter-out $O/tests/bench/%,$(TEST_OBJECTS)): CXXFLAGS := $(patsubst -O2,-O1,$(CXXFLAGS))

check: $(UNIT_TESTS) ## unit tests: no root, seconds
	$(Q)tests/support/run-tests $(UNIT_TESTS)
check-kernel: $(KERNEL_TESTS) ## the real BPF objects on this kernel: root
	$(Q)tests/support/run-tests $(KERNEL_TESTS)
soak: check-sanitized-all soak-fault soak-kills soak-torn soak-bus soak-cluster soak-gateways ## for hours: KILLS= kills, ROUNDS= rounds of torn surroundings, from SEED= where given

$O/bundle/tests/%.o: CXXFLAGS := $(patsubst -O2,-O1,$(CXXFLAGS))
$O/bundle/tests/%.o: CPPFLAGS += $(XML_CFLAGS) $(NL_CFLAGS) $(TOOLS_CPPFLAGS)
$O/bundle/tests/%.o: $O/bundle/tests/%.cc | $(BPF_SKELETONS) $(BPF_TEST_SKELETONS) $(CONTROL_HEADERS) $(DESCRIPTION_TABLES) $(PROTOBUF_HEADERS)
	$(call say,CXX,tests/$* ($(words $(filter-out $(hash)include,$(shell cat $<))) files))
	$(Q)$(CXX) $(STD) $(WARN) -Wno-subobject-linkage $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@

# CI runs each test once: these with AddressSanitizer and UBSan, all others as they are installed.
# They parse untrusted input, or manage the memory of gates, sessions and journals.
SANITIZED := requests_test leases_test bus_load_test bypass_test drops_test turns_test server_test control_test \
	rtnl_test forwarding_test slots_test readback_test drift_test vanish_test gates_lock_test full_disk_test \
	radio_test relay_test
# These are free of errors as well but take too long for CI: attach_test and store_test take minutes
# (journal_fuzz and control_fuzz run the same code), bus_sim_test has fewer sets there, and those of
# the core, of descriptions and of tools compile for minutes (description_fuzz, replies_fuzz).
SANITIZED_ALL := $(SANITIZED) attach_test store_test wire_live_test ether_table_test bus_sim_test can_test core_test \
	description_test mesh_test doctor_test cluster_test
# All others are never run so: they run programs that are not instrumented (analyse_bus, bandwidth,
# check, describe, generate, proto, sources_live, start, tools, twin), use generated code (der) or
# literals that must be constants to be linked (include), or pass frames through the kernel, where
# nothing can be instrumented (gate_frames, ether_frames, ether_sockets). sources_texts_fuzz and
# sources_packets_fuzz cover the input of mlcca-sources.
check-sanitized: $(addprefix $O/fuzz/tests/,$(SANITIZED)) | $(PROGRAMS) ## tests with ASan and UBSan (root): SANITIZED="store_test …"
	$(Q)tests/support/run-tests $^
check-sanitized-all: $(addprefix $O/fuzz/tests/,$(SANITIZED_ALL)) | $(PROGRAMS) ## and those that take too long for CI (root)
	$(Q)tests/support/run-tests $^
PLAIN := $(filter-out $(addprefix $O/tests/,$(SANITIZED)),$(UNIT_TESTS) $(KERNEL_TESTS))
check-plain: $(PLAIN) ## all tests that check-sanitized does not run (root)
	$(Q)tests/support/run-tests $(PLAIN)
.PHONY: check check-kernel soak check-sanitized check-sanitized-all check-plain
-include $(SANITIZED_OBJECTS:.o=.d)
