# mlccactl is linked statically, so that it starts fast in interactive use and runs where our
# libraries are not installed. MLCCACTL_STATIC= links the shared libraries instead.
MLCCACTL_STATIC ?= $(if $(SAN),,-static)
TOOLS_SOURCES := $(filter-out tools/main.cc,$(wildcard tools/*.cc tools/top/*.cc))
# Debian has no static libfmt.
TOOLS_CPPFLAGS := -DFMT_HEADER_ONLY

$(eval $(call library,tools,$(TOOLS_SOURCES)))
# The page of report --html consists of the files of the Cockpit page.
$O/gen/report_page.inc: tools/report/bundle tools/report/ask.js $(wildcard cockpit/*.js cockpit/*.html cockpit/*.css)
	$(call say,PAGE,$@)
	$(Q)mkdir -p $(@D) && tools/report/bundle page cockpit tools/report/ask.js > $@
$O/tools/report.o $O/fuzz/obj/tools/report.o: | $O/gen/report_page.inc
$O/tools/report.o: $O/gen/report_page.inc
# The drawing of check --format html uses the same files.
$O/gen/check_page.inc: tools/report/bundle $(wildcard tools/design/check/page.*s cockpit/*.js cockpit/*.css)
	$(call say,PAGE,$@)
	$(Q)mkdir -p $(@D) && tools/report/bundle check cockpit tools/design/check > $@
$O/tools/design/check/page.o $O/fuzz/obj/tools/design/check/page.o: | $O/gen/check_page.inc
$O/tools/design/check/page.o: $O/gen/check_page.inc
TOOLS_ARCHIVES := $O/libtools.a $O/libcontrol.a $O/libcore.a
$(eval $(call program,mlccactl,tools/main.cc,$(TOOLS_ARCHIVES),))
$(tools_objects) $(mlccactl_objects): CPPFLAGS += $(TOOLS_CPPFLAGS)
$O/mlccactl: LDFLAGS += $(MLCCACTL_STATIC)
PROGRAMS += $O/mlccactl

# The analysis of traffic for `mlccactl learn`.
$(eval $(call library,learn,$(wildcard tools/learn/*.cc)))
$(learn_objects): CPPFLAGS += $(TOOLS_CPPFLAGS)

# The design-time verbs (check, describe, generate, learn …): mlccactl starts this program for them.
$(eval $(call library,design,$(filter-out tools/design/main.cc,$(wildcard tools/design/*.cc tools/design/*/*.cc))))
YAML_LIBS := $(shell $(PKG_CONFIG) --libs yaml-0.1 2>/dev/null)
DESIGN_LIBS := $(XML_LIBS) $(YAML_LIBS) $(NL_LIBS) -lz
# `learn` reads the rules of can-gw.
DESIGN_ARCHIVES := $O/libdesign.a $O/daemon/net/can_routes.o $O/daemon/net/rtnl.o $O/liblearn.a $O/librelay.a $O/libtools.a $O/libdescription.a $O/libcontrol.a $O/libcore.a
$(eval $(call program,mlcca-design,tools/design/main.cc,$(DESIGN_ARCHIVES),$(DESIGN_LIBS)))
$(design_objects) $(mlcca-design_objects): CPPFLAGS += $(TOOLS_CPPFLAGS) $(XML_CFLAGS) $(NL_CFLAGS)
PROGRAMS += $O/mlcca-design

install-design: $O/mlcca-design
	$(call say,INSTALL,the verbs of design time)
	$(Q)install -d $(DESTDIR)$(PREFIX)/libexec/mlcca
	$(Q)install -m 755 $O/mlcca-design $(DESTDIR)$(PREFIX)/libexec/mlcca/mlcca-design
PARTS += install-design
.PHONY: install-design

# The folder in which zsh on Debian finds completions of packages; elsewhere set ZSHDIR.
ZSHDIR ?= $(PREFIX)/share/zsh/$(if $(filter /usr,$(PREFIX)),vendor-completions,site-functions)
install-tools-extras:
	$(call say,INSTALL,manual pages and shell completion)
	$(Q)install -d $(addprefix $(DESTDIR)$(PREFIX)/share/,man/man1 man/man8 bash-completion/completions \
		fish/vendor_completions.d) $(DESTDIR)$(ZSHDIR)
	$(Q)install -m 644 $(wildcard docs/man/mlccactl*.1) $(DESTDIR)$(PREFIX)/share/man/man1
	$(Q)install -m 644 $(wildcard docs/man/*.8) $(DESTDIR)$(PREFIX)/share/man/man8
	$(Q)install -m 644 tools/completion/mlccactl.bash \
		$(DESTDIR)$(PREFIX)/share/bash-completion/completions/mlccactl
	$(Q)install -m 644 tools/completion/mlccactl.fish $(DESTDIR)$(PREFIX)/share/fish/vendor_completions.d
	$(Q)install -m 644 tools/completion/_mlccactl $(DESTDIR)$(ZSHDIR)
PARTS += install-tools-extras
.PHONY: install-tools-extras

# Data of untrusted peers is parsed in mlcca-sources alone; mlccad does not link this archive.
$(eval $(call library,untrusted,$(filter-out tools/sources/main.cc,$(wildcard tools/sources/*.cc))))
SOURCES_ARCHIVES := $O/libuntrusted.a $O/libsources.a $O/libcore.a $O/libbase.a
$(eval $(call program,mlcca-sources,tools/sources/main.cc,$(SOURCES_ARCHIVES),-lsystemd))
PROGRAMS += $O/mlcca-sources

# Opens the CAN socket that the unit of mlccad does not permit it to open.
$(eval $(call program,mlcca-can,tools/can/main.cc,,))
PROGRAMS += $O/mlcca-can

# Carries out `mlccactl gate --verify`.
$(eval $(call program,mlcca-readback,$(wildcard tools/readback/*.cc),$(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
PROGRAMS += $O/mlcca-readback
install-readback: $O/mlcca-readback
	$(call say,INSTALL,the reader of what is in force)
	$(Q)install -d $(DESTDIR)$(PREFIX)/libexec/mlcca
	$(Q)install -m 755 $O/mlcca-readback $(DESTDIR)$(PREFIX)/libexec/mlcca/mlcca-readback
PARTS += install-readback
.PHONY: install-readback

# Carries out `mlccactl doctor`.
$(eval $(call library,doctor,$(filter-out tools/doctor/main.cc,$(wildcard tools/doctor/*.cc))))
$(eval $(call program,mlcca-doctor,tools/doctor/main.cc,$O/libdoctor.a $(DAEMON_ARCHIVES),$(DAEMON_LIBS)))
PROGRAMS += $O/mlcca-doctor
install-doctor: $O/mlcca-doctor
	$(call say,INSTALL,the doctor)
	$(Q)install -d $(DESTDIR)$(PREFIX)/libexec/mlcca
	$(Q)install -m 755 $O/mlcca-doctor $(DESTDIR)$(PREFIX)/libexec/mlcca/mlcca-doctor
PARTS += install-doctor
.PHONY: install-doctor

# The only service that listens to a network interface; it passes packets on through a socket.
$(eval $(call program,mlcca-awds,$(wildcard tools/awds/*.cc),$O/libsources.a $O/libbase.a,$(SOURCES_LIBS)))
PROGRAMS += $O/mlcca-awds

# Metrics for Prometheus; the alert rules and the dashboard are for the server of Prometheus.
$(eval $(call library,exporter,$(filter-out tools/exporter/main.cc,$(wildcard tools/exporter/*.cc))))
EXPORTER_ARCHIVES := $O/libexporter.a $O/libcontrol.a $O/libcore.a $O/libbase.a
EXPORTER_LIBS := -lmicrohttpd -lsystemd
$(eval $(call program,mlcca-exporter,tools/exporter/main.cc,$(EXPORTER_ARCHIVES),$(EXPORTER_LIBS) -lfmt))
PROGRAMS += $O/mlcca-exporter
install-exporter: $O/mlcca-exporter
	$(call say,INSTALL,the exporter with rules and dashboard)
	$(Q)install -d $(addprefix $(DESTDIR)$(PREFIX)/,sbin share/mlcca-exporter)
	$(Q)install -m 755 $O/mlcca-exporter $(DESTDIR)$(PREFIX)/sbin/mlcca-exporter
	$(Q)install -m 644 tools/exporter/alerts.yml tools/exporter/dashboard.json \
		$(DESTDIR)$(PREFIX)/share/mlcca-exporter
PARTS += install-exporter
.PHONY: install-exporter
