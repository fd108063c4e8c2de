# The folders where the system expects these files do not depend on PREFIX, but the programs that
# the units start do.
UNITDIR ?= /usr/lib/systemd/system
UDEVDIR ?= /usr/lib/udev/rules.d
SYSUSERSDIR ?= /usr/lib/sysusers.d
TMPFILESDIR ?= /usr/lib/tmpfiles.d
MAKE_UNIT = sed -e 's|@sbindir@|$(PREFIX)/sbin|g' -e 's|@bindir@|$(PREFIX)/bin|g' \
	-e 's|@libexecdir@|$(PREFIX)/libexec|g'

install-systemd:
	$(call say,INSTALL,units, udev rule, sysusers, tmpfiles)
	$(Q)install -d $(DESTDIR)$(UNITDIR) $(DESTDIR)$(UDEVDIR) $(DESTDIR)$(SYSUSERSDIR) \
		$(DESTDIR)$(TMPFILESDIR) $(DESTDIR)/etc/mlcca/conf.d
	$(Q)install -m 644 systemd/mlccad.socket systemd/run-mlcca-bpf.mount \
		systemd/mlcca-awds@.socket systemd/mlcca-exporter.socket systemd/mlcca-sources.socket \
		systemd/mlcca-can.socket \
		systemd/mlcca-cluster.socket $(DESTDIR)$(UNITDIR)
	$(Q)$(MAKE_UNIT) systemd/mlccad.service.in > $(DESTDIR)$(UNITDIR)/mlccad.service
	$(Q)$(MAKE_UNIT) systemd/mlcca-relay.service.in > $(DESTDIR)$(UNITDIR)/mlcca-relay.service
	$(Q)$(MAKE_UNIT) systemd/mlcca-famouso.service.in > $(DESTDIR)$(UNITDIR)/mlcca-famouso.service
	$(Q)$(MAKE_UNIT) systemd/mlcca-exporter.service.in > $(DESTDIR)$(UNITDIR)/mlcca-exporter.service
	$(Q)$(MAKE_UNIT) systemd/mlcca-cluster.service.in > $(DESTDIR)$(UNITDIR)/mlcca-cluster.service
	$(Q)$(MAKE_UNIT) systemd/mlcca-drain.service.in > $(DESTDIR)$(UNITDIR)/mlcca-drain.service
	$(Q)$(MAKE_UNIT) systemd/mlcca-gate.service.in > $(DESTDIR)$(UNITDIR)/mlcca-gate.service
	$(Q)$(MAKE_UNIT) systemd/mlcca-awds@.service.in > $(DESTDIR)$(UNITDIR)/mlcca-awds@.service
	$(Q)$(MAKE_UNIT) systemd/mlcca-sources@.service.in > $(DESTDIR)$(UNITDIR)/mlcca-sources@.service
	$(Q)$(MAKE_UNIT) systemd/mlcca-can@.service.in > $(DESTDIR)$(UNITDIR)/mlcca-can@.service
	$(Q)$(MAKE_UNIT) systemd/90-mlcca.rules.in > $(DESTDIR)$(UDEVDIR)/90-mlcca.rules
	$(Q)install -m 644 systemd/mlcca.sysusers $(DESTDIR)$(SYSUSERSDIR)/mlcca.conf
	$(Q)install -m 644 systemd/mlcca.tmpfiles $(DESTDIR)$(TMPFILESDIR)/mlcca.conf
	$(Q)for f in gate.conf mlccad.conf famouso.conf; do \
		[ -e $(DESTDIR)/etc/mlcca/$$f ] || install -m 644 systemd/$$f $(DESTDIR)/etc/mlcca/$$f; done
	$(Q)install -m 644 systemd/conf.d.README $(DESTDIR)/etc/mlcca/conf.d/README
install-programs: $(PROGRAMS)
	$(call say,INSTALL,$(PREFIX)/sbin/mlccad $(PREFIX)/bin/mlccactl)
	$(Q)install -d $(addprefix $(DESTDIR)$(PREFIX)/,sbin bin libexec/mlcca)
	$(Q)install -m 755 $O/mlccad $(DESTDIR)$(PREFIX)/sbin/mlccad
	$(Q)install -m 755 $O/mlcca-relay $(DESTDIR)$(PREFIX)/sbin/mlcca-relay
	$(Q)install -m 755 $O/mlcca-famouso $(DESTDIR)$(PREFIX)/sbin/mlcca-famouso
	$(Q)install -m 755 $O/mlccactl $(DESTDIR)$(PREFIX)/bin/mlccactl
	$(Q)install -m 755 $O/mlcca-awds $(DESTDIR)$(PREFIX)/libexec/mlcca/mlcca-awds
	$(Q)install -m 755 $O/mlcca-sources $(DESTDIR)$(PREFIX)/libexec/mlcca/mlcca-sources
	$(Q)install -m 755 $O/mlcca-can $(DESTDIR)$(PREFIX)/libexec/mlcca/mlcca-can
PARTS += install-programs install-systemd
.PHONY: install-systemd install-programs
