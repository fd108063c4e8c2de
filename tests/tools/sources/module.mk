# Link sources that other programs report. Tests named *_live_test.cc need root and their own
# namespaces.
$(eval $(call unit_test,proto_test,$(filter-out %_live_test.cc,$(wildcard tests/tools/sources/proto_*.cc)),$(SOURCES_ARCHIVES),$(SOURCES_LIBS) -lfmt))
$(eval $(call kernel_test,sources_live_test,tests/tools/sources/proto_live_test.cc tests/tools/sources/proto_owner_live_test.cc tests/tools/sources/proto_loop.cc,$(SOURCES_ARCHIVES),$(SOURCES_LIBS) -lfmt))
$(eval $(call program,tests/watch-source,tests/tools/sources/watch_source.cc,$(SOURCES_ARCHIVES),$(SOURCES_LIBS) -lfmt))
$(patsubst %.cc,$O/%.o,$(wildcard tests/tools/sources/*.cc)): CPPFLAGS += $(NL_CFLAGS)

# No distribution has AWDS, so its packets come from an emulator of this tree.
$(eval $(call program,tests/awds-emulator,tests/tools/sources/awds_emulator.cc tests/tools/sources/proto_emulated.cc,,))
$O/tests/sources_live_test: | $O/tests/awds-emulator $O/mlcca-awds $O/mlcca-sources
$O/tests/proto_test $O/tests/watch-source: | $O/mlcca-sources

check-guest: $O/tests/watch-source $O/tests/awds-emulator
