# Sources of link state. What the kernel tells: radio_*; what other programs tell: proto_*. Tests named
# *_live_test.cc need root and namespaces of their own.
SOURCES_ARCHIVES := $O/libstrangers.a $O/libsources.a
$(eval $(call unit_test,radio_test,$(filter-out %_live_test.cc,$(wildcard tests/sources/radio_*.cc)),$(SOURCES_ARCHIVES),$(SOURCES_LIBS) -lfmt))
$(eval $(call unit_test,proto_test,$(filter-out %_live_test.cc,$(wildcard tests/sources/proto_*.cc)),$(SOURCES_ARCHIVES),$(SOURCES_LIBS) -lfmt))
$(eval $(call kernel_test,sources_live_test,tests/sources/proto_live_test.cc tests/sources/proto_owner_live_test.cc tests/sources/proto_loop.cc,$(SOURCES_ARCHIVES),$(SOURCES_LIBS) -lfmt))
$(eval $(call kernel_test,wire_live_test,tests/sources/radio_wire_live_test.cc,$(SOURCES_ARCHIVES),$(SOURCES_LIBS)))
$(eval $(call program,tests/watch-source,tests/sources/watch_source.cc,$(SOURCES_ARCHIVES),$(SOURCES_LIBS) -lfmt))
$(patsubst %.cc,$O/%.o,$(wildcard tests/sources/*.cc)): CPPFLAGS += $(NL_CFLAGS)

# AWDS is in no distribution: its packets come from a program of ours.
$(eval $(call program,tests/awds-emulator,tests/sources/awds_emulator.cc tests/sources/proto_emulated.cc,,))
$O/tests/sources_live_test: | $O/tests/awds-emulator $O/mlcca-awds $O/mlcca-sources
$O/tests/proto_test $O/tests/watch-source: | $O/mlcca-sources

check-guest: $O/tests/watch-source $O/tests/awds-emulator
