$(eval $(call library,control,$(wildcard control/*.cc)))
