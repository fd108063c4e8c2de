# The page for Cockpit: the files are installed as they are, without a build step.
COCKPIT_FILES := $(filter-out %.mk,$(wildcard cockpit/*))
install-cockpit:
	$(call say,INSTALL,the page of Cockpit)
	$(Q)install -d $(DESTDIR)$(PREFIX)/share/cockpit/mlcca
	$(Q)install -m 644 $(COCKPIT_FILES) $(DESTDIR)$(PREFIX)/share/cockpit/mlcca
PARTS += install-cockpit

check-cockpit: check-report $O/mlccad $O/mlccactl ## the page in Chromium, of a real cockpit-ws and daemon (root): SCREENSHOTS=folder
	$(Q)tests/cockpit/run $O $(SCREENSHOTS)
check-report: $O/mlccactl $O/mlcca-design ## what check --format html writes, in Chromium
	$(Q)tests/cockpit/report $O $(SCREENSHOTS)
.PHONY: install-cockpit check-cockpit check-report
