# What waits for nobody, and what needs the event loop or systemd. Everything else in base/ is in headers.
$(eval $(call library,base,$(wildcard base/*.cc)))
