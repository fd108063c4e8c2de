# Runs the commands in the documentation and compares their output. This target runs those that need
# no gateway, the guest test `documents` those that need one, and check-docs-cluster those of
# gateways that share a store. NOT_RUN is the number of blocks that say why they are not run.
NOT_RUN := 41
check-docs: $O/mlccactl $O/mlcca-design $O/mlcca-doctor $O/mlcca-system.5 ## links, drawings and form of the documentation, and its commands
	$(Q)tests/docs/form
	$(Q)tests/docs/layers
	$(Q)tests/docs/names
	$(Q)tests/docs/installed
	$(Q)tests/bench/age check
	$(Q)BUILD=$(abspath $O) tests/docs/man
	$(Q)BUILD=$(abspath $O) tests/docs/additions
	$(Q)tests/docs/sessions count $(NOT_RUN)
	$(Q)tests/docs/cluster/story names
	$(Q)BUILD=$(abspath $O) tests/docs/sessions host
.PHONY: check-docs
# Three gateways and an etcd of three members, in network namespaces: some 80 s, half of which
# is spent waiting.
check-docs-cluster: $O/mlccad $O/mlccactl $O/mlcca-design $O/mlcca-cluster ## the commands of the documentation for gateways that share a store: root
	$(Q)BUILD=$(abspath $O) tests/docs/cluster/run
.PHONY: check-docs-cluster
