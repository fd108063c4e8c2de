# SPDX-License-Identifier: BSD-2-Clause
# Tests of the run-time representation and of narrow values, alone and compared with other
# implementations of the notation: the C code that asn1c generates from proto/mlcca.asn1, and
# openssl.
ASN1C ?= asn1c
ASN1_LIBRARY := $O/asn1/libasn1.a
$(ASN1_LIBRARY): proto/mlcca.asn1
	$(call say,ASN1C,$<)
	$(Q)rm -rf $(@D) && mkdir -p $(@D)
	$(Q)cd $(@D) && $(ASN1C) -fwide-types -fcompound-names $(abspath $<) >asn1c.log 2>&1 || { cat asn1c.log; exit 1; }
	$(Q)cd $(@D) && rm -f converter-sample.c && $(CC) -w -O1 -I. -c *.c && ar rcs $(@F) *.o

$(eval $(call unit_test,der_test,$(wildcard tests/include/der/*_test.cc),$(ASN1_LIBRARY)))
$O/tests/include/der/asn1c_test.o: CPPFLAGS += -isystem $O/asn1
$O/tests/include/der/asn1c_test.o: | $(ASN1_LIBRARY)
