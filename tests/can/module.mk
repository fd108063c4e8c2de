$(eval $(call unit_test,can_test,$(wildcard tests/can/*.cc),$O/libcore.a,))
