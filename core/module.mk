$(eval $(call library,core,$(wildcard core/*.cc)))
