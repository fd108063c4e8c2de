$(eval $(call unit_test,turns_test,tests/daemon/serve/turns_test.cc,$O/daemon/serve/turns.o,))
$(eval $(call unit_test,places_test,tests/daemon/serve/places_test.cc,$O/daemon/serve/places.o,))
$(eval $(call unit_test,arrivals_test,tests/daemon/serve/arrivals_test.cc,$O/daemon/serve/arrivals.o $O/daemon/serve/turns.o,))
# Needs root, because the clients belong to several users.
$(eval $(call kernel_test,server_test,tests/daemon/serve/server_test.cc tests/daemon/serve/events_test.cc,$(patsubst %.cc,$O/%.o,$(wildcard daemon/serve/*.cc)) $O/libcontrol.a,-lsystemd))

$O/tests/turn_times.so: tests/daemon/serve/turn_times.c
	$(call say,CC,$@)
	$(Q)mkdir -p $(@D) && $(CC) -std=gnu17 -O1 -fPIC -shared -Wall -Wextra $(WERROR) -o $@ $<
check-neighbour: $O/mlccad $O/tests/turn_times.so ## 50 hostile clients on a gateway with 100,000 channels: root
	$(call say,TEST,a hostile neighbour)
	$(Q)tests/daemon/serve/neighbour $O
check-quotas: $O/mlccad ## what a member of the control group may hold and change: root
	$(call say,TEST,quotas of users)
	$(Q)tests/daemon/serve/quotas $O
.PHONY: check-neighbour check-quotas
