#The corpus and the examples are found below the source root, where tests are run.
$(eval $(call unit_test,description_test,$(wildcard tests/description/*.cc),$O/libdescription.a $O/libcore.a,$(XML_LIBS) -lfmt))
$(patsubst %.cc,$O/%.o,$(wildcard tests/description/*.cc)): CPPFLAGS += $(XML_CFLAGS)

# The reader under libFuzzer: its own sources with sanitizers, core as it is built anyway.
DESCRIPTION_FUZZ := $O/fuzz/description_fuzz
DESCRIPTION_CORPUS := tests/corpus/description/good tests/corpus/description/bad
$(DESCRIPTION_FUZZ): tests/fuzz/description_fuzz.cc $(wildcard description/*.cc description/*.hpp) \
		$O/gen/system_xsd.inc $O/libcore.a
	$(call say,FUZZ,$<)
	$(Q)mkdir -p $(@D) && $(FUZZ_CXX) $(FUZZ_FLAGS) -Wno-deprecated-declarations -isystem $O/gen $(XML_CFLAGS) \
		$(filter %.cc,$^) $O/libcore.a $(XML_LIBS) -lfmt -o $@

check-fuzz: check-fuzz-description
check-fuzz-description: $(DESCRIPTION_FUZZ)
	$(Q)rm -rf $O/fuzz/description && mkdir -p $O/fuzz/description
	$(Q)$< -seed=1 -runs=20000 -max_len=4096 -only_ascii=0 -artifact_prefix=$O/fuzz/ \
		$O/fuzz/description $(DESCRIPTION_CORPUS) >$O/fuzz/description_fuzz.log 2>&1 || \
		{ tail -n 40 $O/fuzz/description_fuzz.log; exit 1; }
	@echo "  PASS    description_fuzz: the corpus and 20000 mutations"

fuzz-description: $(DESCRIPTION_FUZZ) ## the reader of descriptions (FUZZ_SECONDS=600), corpus below $O/fuzz
	$(Q)mkdir -p $O/fuzz/description-corpus
	$< -max_len=16384 -max_total_time=$(FUZZ_SECONDS) -print_final_stats=1 \
		-artifact_prefix=$O/fuzz/ $O/fuzz/description-corpus $(DESCRIPTION_CORPUS)
.PHONY: check-fuzz-description fuzz-description
