include $(wildcard tests/*/module.mk)
$(patsubst %.cc,$O/%.o,$(wildcard tests/*/*.cc)): CPPFLAGS += -Itests

check: $(UNIT_TESTS) ## unit tests: no root, seconds
	$(Q)tests/support/run-tests $(UNIT_TESTS)
check-kernel: $(KERNEL_TESTS) ## the real BPF objects on this kernel: root
	$(Q)tests/support/run-tests $(KERNEL_TESTS)
.PHONY: check check-kernel
