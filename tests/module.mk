include $(wildcard tests/*/module.mk)
TEST_OBJECTS := $(patsubst %.cc,$O/%.o,$(wildcard tests/*/*.cc))
$(TEST_OBJECTS): CPPFLAGS += -Itests
# What is tested is optimised; the tests themselves would cost most of the time of a build.
$(filter-out $O/tests/bench/%,$(TEST_OBJECTS)): CXXFLAGS := $(patsubst -O2,-O1,$(CXXFLAGS))

check: $(UNIT_TESTS) ## unit tests: no root, seconds
	$(Q)tests/support/run-tests $(UNIT_TESTS)
check-kernel: $(KERNEL_TESTS) ## the real BPF objects on this kernel: root
	$(Q)tests/support/run-tests $(KERNEL_TESTS)
soak: soak-fault soak-kills soak-torn ## for hours: KILLS= kills, ROUNDS= rounds of torn surroundings, from SEED= where given

# CI runs each test once: these under AddressSanitizer and UBSan, all others as they are installed.
SANITIZED := requests_test leases_test bus_load_test bypass_test drops_test
check-sanitized: $(addprefix $O/fuzz/tests/,$(SANITIZED)) | $(PROGRAMS) ## tests with ASan and UBSan (root): SANITIZED="store_test …"
	$(Q)tests/support/run-tests $(addprefix $O/fuzz/tests/,$(SANITIZED))
PLAIN := $(filter-out $(addprefix $O/tests/,$(SANITIZED)),$(UNIT_TESTS) $(KERNEL_TESTS))
check-plain: $(PLAIN) ## all tests that check-sanitized does not run (root)
	$(Q)tests/support/run-tests $(PLAIN)
.PHONY: check check-kernel soak check-sanitized check-plain
-include $(SANITIZED_OBJECTS:.o=.d)
