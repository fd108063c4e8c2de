# Counts the comparisons that a program makes, instead of its time. The objects are instrumented as
# for the fuzzers.
WORK_SOURCES := $(wildcard tests/tools/design/comparisons/*.cc tools/design/generate/*.cc tools/design/analyse_bus/*.cc) \
	$(addprefix tools/design/,generate.cc safe_file.cc say.cc) tools/table.cc tools/values.cc
WORK_OBJECTS := $(patsubst %.cc,$O/fuzz/obj/%.o,$(wildcard $(WORK_SOURCES)))
$O/fuzz/obj/tests/tools/design/comparisons/%.o: CPPFLAGS += $(TOOLS_CPPFLAGS)
$O/tests/work_test: $(WORK_OBJECTS) $O/fuzz/libdescription.a $O/fuzz/libcore.a
	$(call say,LINK,$@)
	$(Q)mkdir -p $(@D) && $(FUZZ_CXX) -fsanitize=$(FUZZ_SANITIZERS) -o $@ $^ $(XML_LIBS) -lfmt -lgtest -lgtest_main
# This is not part of `make check`, which does not need the runtime of clang.
check-work: $O/tests/work_test ## generate takes what grows with the description, counted
	$(Q)tests/support/run-tests $^
.PHONY: check-work
-include $(WORK_OBJECTS:.o=.d)
