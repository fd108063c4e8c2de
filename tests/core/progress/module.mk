$(eval $(call unit_test,progress_test,tests/core/progress/progress_test.cc tests/support/stretches.cc,$O/libcore.a,))
