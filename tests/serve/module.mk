$(eval $(call unit_test,turns_test,tests/serve/turns_test.cc,$O/daemon/serve/turns.o,))
$(eval $(call unit_test,server_test,tests/serve/server_test.cc,$(patsubst %.cc,$O/%.o,$(wildcard daemon/serve/*.cc)) $O/libcontrol.a,-lsystemd $(PROTO_LIBS)))

check-neighbour: $O/mlccad ## 50 hostile clients on a gateway with 100,000 channels: root
	$(call say,TEST,a hostile neighbour)
	$(Q)tests/serve/neighbour $O
.PHONY: check-neighbour
