$(eval $(call unit_test,shared_test,$(wildcard tests/core/shared/*.cc),$O/libcore.a,))
