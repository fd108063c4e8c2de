$(eval $(call library,core,$(wildcard core/*.cc core/*/*.cc)))
