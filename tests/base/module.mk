$(eval $(call unit_test,base_test,$(wildcard tests/base/*.cc),$O/libbase.a,))
