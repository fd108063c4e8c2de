$(eval $(call unit_test,core_test,$(foreach part,model admission design profiles gates reserve,$(wildcard tests/core/$(part)/*.cc)),$O/libcore.a,))
