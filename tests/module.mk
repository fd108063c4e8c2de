include $(wildcard tests/*/module.mk)
TEST_OBJECTS := $(patsubst %.cc,$O/%.o,$(wildcard tests/*/*.cc))
$(TEST_OBJECTS): CPPFLAGS += -Itests
# What is tested is optimised; the tests themselves would cost most of the time of a build.
$(filter-out $O/tests/bench/%,$(TEST_OBJECTS)): CXXFLAGS := $(patsubst -O2,-O1,$(CXXFLAGS))

check: $(UNIT_TESTS) ## unit tests: no root, seconds
	$(Q)tests/support/run-tests $(UNIT_TESTS)
check-kernel: $(KERNEL_TESTS) ## the real BPF objects on this kernel: root
	$(Q)tests/support/run-tests $(KERNEL_TESTS)
.PHONY: check check-kernel
