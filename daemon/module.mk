# All files except main.cc are in a library, so that tests link the same objects.
NL_CFLAGS := $(shell $(PKG_CONFIG) --cflags libnl-3.0 libnl-route-3.0 libnl-genl-3.0 2>/dev/null | sed 's/-I/-isystem /g')
NL_LIBS := $(shell $(PKG_CONFIG) --libs libnl-genl-3.0 libnl-route-3.0 libnl-3.0 2>/dev/null)
DAEMON_LIBS := $(NL_LIBS) -lsystemd -lsqlite3 -lbpf $(XML_LIBS) -lfmt

$(eval $(call library,enforce,$(wildcard daemon/gates/*.cc)))
$(enforce_objects): $(BPF_SKELETONS)
# The adapters of link sources are in a separate archive, so that tests can link them alone.
$(eval $(call library,sources,$(wildcard daemon/net/sources/*.cc)))
$(sources_objects): CPPFLAGS += $(NL_CFLAGS)
SOURCES_LIBS := $(NL_LIBS) -lsystemd
$(eval $(call library,daemon,$(filter-out daemon/main.cc,$(wildcard daemon/*.cc $(addprefix daemon/,gateway/*.cc gateway/requests/*.cc net/*.cc outside/*.cc ports/*.cc serve/*.cc store/*.cc)))))
$(daemon_objects) $O/daemon/net/%.o: CPPFLAGS += $(NL_CFLAGS)
DAEMON_ARCHIVES := $O/libdaemon.a $O/libclustercodec.a $O/libclusterlink.a $O/libsources.a $O/libenforce.a $O/libcontrol.a $O/libdescription.a $O/libcore.a $O/libbase.a
$(eval $(call program,mlccad,daemon/main.cc,$(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
PROGRAMS += $O/mlccad
