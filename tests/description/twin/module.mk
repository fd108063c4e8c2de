# Tests of description/check.xsl and reference.xsl with xsltproc. They run at the source root.
$(eval $(call unit_test,twin_test,$(wildcard tests/description/twin/*.cc),$O/libdescription.a $O/libcore.a,$(XML_LIBS) -lfmt))
