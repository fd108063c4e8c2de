$O/tests/daemon/net/can_routes_test.o $O/tests/daemon/net/rtnl_test.o: CPPFLAGS += $(NL_CFLAGS)
$(eval $(call unit_test,rtnl_test,tests/daemon/net/rtnl_test.cc,$(addprefix $O/daemon/net/,rtnl.o links.o),$(NL_LIBS)))
$(eval $(call unit_test,can_socket_test,tests/daemon/net/can_socket_test.cc,$O/daemon/net/can_socket.o $O/libsources.a,$(NL_LIBS) -lsystemd -lfmt))
# Link sources that the kernel reports. Tests named *_live_test.cc need root and their own
# namespaces.
$(eval $(call unit_test,radio_test,$(filter-out %_live_test.cc,$(wildcard tests/daemon/net/sources/radio_*.cc)),$(SOURCES_ARCHIVES),$(SOURCES_LIBS) -lfmt))
$(eval $(call kernel_test,wire_live_test,tests/daemon/net/sources/radio_wire_live_test.cc,$(SOURCES_ARCHIVES),$(SOURCES_LIBS)))
$(patsubst %.cc,$O/%.o,$(wildcard tests/daemon/net/sources/*.cc)): CPPFLAGS += $(NL_CFLAGS)
