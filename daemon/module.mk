# Everything but main.cc is a library, so that tests link the same objects.
NL_CFLAGS := $(shell $(PKG_CONFIG) --cflags libnl-3.0 libnl-route-3.0 libnl-genl-3.0 2>/dev/null | sed 's/-I/-isystem /g')
NL_LIBS := $(shell $(PKG_CONFIG) --libs libnl-genl-3.0 libnl-route-3.0 libnl-3.0 2>/dev/null)
DAEMON_LIBS := $(NL_LIBS) -lsystemd -lsqlite3 -lbpf $(XML_LIBS) $(PROTO_LIBS) -lfmt

$(eval $(call library,enforce,$(wildcard daemon/enforce/*.cc)))
$(enforce_objects): $(BPF_SKELETONS)
# Adapters of what knows the state of links: an archive of their own, so that tests link them alone.
# Those that read what strangers write are in another, which mlccad does not have.
$(eval $(call library,sources,$(wildcard daemon/net/sources/*.cc)))
$(sources_objects): CPPFLAGS += $(NL_CFLAGS)
SOURCES_LIBS := $(NL_LIBS) -lsystemd
$(eval $(call library,strangers,$(filter-out daemon/sources/main.cc,$(wildcard daemon/sources/*.cc))))
$(eval $(call program,mlcca-sources,daemon/sources/main.cc daemon/manager.cc,$O/libstrangers.a $O/libsources.a,-lsystemd))
PROGRAMS += $O/mlcca-sources
$(eval $(call library,daemon,$(filter-out daemon/main.cc,$(wildcard daemon/*.cc daemon/net/*.cc daemon/serve/*.cc daemon/store/*.cc))))
$(daemon_objects): CPPFLAGS += $(NL_CFLAGS)
DAEMON_ARCHIVES := $O/libdaemon.a $O/libsources.a $O/libenforce.a $O/libcontrol.a $O/libdescription.a $O/libcore.a
$(eval $(call program,mlccad,daemon/main.cc,$(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
PROGRAMS += $O/mlccad

# What `mlccactl gate --verify` becomes.
$(eval $(call program,mlcca-readback,$(wildcard daemon/readback/*.cc),$(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
PROGRAMS += $O/mlcca-readback
install-readback: $O/mlcca-readback
	$(call say,INSTALL,the reader of what is in force)
	$(Q)install -d $(DESTDIR)$(PREFIX)/libexec/mlcca
	$(Q)install -m 755 $O/mlcca-readback $(DESTDIR)$(PREFIX)/libexec/mlcca/mlcca-readback
INSTALL += install-readback
.PHONY: install-readback

# What `mlccactl doctor` becomes.
$(eval $(call library,doctor,$(filter-out daemon/doctor/main.cc,$(wildcard daemon/doctor/*.cc))))
$(eval $(call program,mlcca-doctor,daemon/doctor/main.cc,$O/libdoctor.a $(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
PROGRAMS += $O/mlcca-doctor
install-doctor: $O/mlcca-doctor
	$(call say,INSTALL,the doctor)
	$(Q)install -d $(DESTDIR)$(PREFIX)/libexec/mlcca
	$(Q)install -m 755 $O/mlcca-doctor $(DESTDIR)$(PREFIX)/libexec/mlcca/mlcca-doctor
INSTALL += install-doctor
.PHONY: install-doctor

# The only program that may listen to a network interface; mlccad reads it through a socket.
$(eval $(call program,mlcca-awds,$(wildcard daemon/awds/*.cc) daemon/listen.cc daemon/manager.cc,$O/libsources.a,$(SOURCES_LIBS)))
PROGRAMS += $O/mlcca-awds
