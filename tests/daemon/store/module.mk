# Tests of the store alone, which need nothing else of the daemon.
STORE_PARTS := $(patsubst %.cc,$O/%.o,$(wildcard daemon/store/*.cc)) $O/libcontrol.a
STORE_TESTS := $(addprefix tests/daemon/store/,contents_test.cc records_test.cc journal_test.cc tail_test.cc power_test.cc \
	failing_disk_test.cc kill_test.cc history_test.cc history_notes_test.cc fake_disk.cc worlds.cc)
$(eval $(call unit_test,store_test,$(STORE_TESTS),$(STORE_PARTS),-lsqlite3))
$(eval $(call kernel_test,full_disk_test,tests/daemon/store/full_disk_test.cc tests/daemon/store/worlds.cc,$(STORE_PARTS),-lsqlite3))
