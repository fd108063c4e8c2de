# Runs the commands in the documentation and compares their output. This target runs those that need
# no gateway, and the guest test `documents` the others. NOT_RUN names blocks that say why they are
# not run.
NOT_RUN := 10
check-docs: $O/mlccactl $O/mlcca-design $O/mlcca-doctor $O/mlcca-system.5 ## links, drawings and form of the documentation, and its commands
	$(Q)tests/docs/form
	$(Q)tests/docs/layers
	$(Q)tests/docs/installed
	$(Q)tests/bench/age check
	$(Q)BUILD=$(abspath $O) tests/docs/man
	$(Q)BUILD=$(abspath $O) tests/docs/additions
	$(Q)tests/docs/sessions count $(NOT_RUN)
	$(Q)BUILD=$(abspath $O) tests/docs/sessions host
.PHONY: check-docs
