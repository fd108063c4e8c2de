$(eval $(call unit_test,interface_files_test,tests/daemon/interface_files_test.cc,$O/daemon/interface_files.o,-lfmt))
$(eval $(call unit_test,description_files_test,tests/daemon/description_files_test.cc,$O/daemon/description_files.o $O/libdescription.a $O/libcore.a,$(XML_LIBS) -lfmt))
