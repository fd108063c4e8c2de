$(eval $(call unit_test,can_test,$(wildcard tests/core/can/*.cc),$O/libcore.a,))
