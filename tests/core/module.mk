$(eval $(call unit_test,core_test,$(wildcard tests/core/*.cc),$O/libcore.a,))
