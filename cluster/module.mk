# mlcca-cluster, which connects mlccad to the store of a cluster. Only this program has libcurl and
# the key.
CURL_LIBS := $(shell $(PKG_CONFIG) --libs libcurl 2>/dev/null)
# mlccad's end of the socket between both programs, and the messages that both use.
$(eval $(call library,clusterlink,daemon/cluster/wire.cc daemon/cluster/link.cc))
# The encoding of the values in the store, which only mlccad needs.
$(eval $(call library,clustercodec,daemon/cluster/record_codec.cc))
$(eval $(call library,cluster,$(filter-out cluster/main.cc,$(wildcard cluster/*.cc))))
CLUSTER_ARCHIVES := $O/libcluster.a $O/libclusterlink.a $O/libsources.a $O/libbase.a
CLUSTER_LIBS := $(CURL_LIBS) -lsystemd
$(eval $(call program,mlcca-cluster,cluster/main.cc,$(CLUSTER_ARCHIVES),$(CLUSTER_LIBS)))
PROGRAMS += $O/mlcca-cluster
install-cluster: $O/mlcca-cluster
	$(call say,INSTALL,the way to the store)
	$(Q)install -d $(DESTDIR)$(PREFIX)/sbin
	$(Q)install -m 755 $O/mlcca-cluster $(DESTDIR)$(PREFIX)/sbin/mlcca-cluster
PARTS += install-cluster
.PHONY: install-cluster
