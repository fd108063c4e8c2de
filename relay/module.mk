# SPDX-License-Identifier: BSD-2-Clause
# The relay, which forwards events between networks, and the protocols of FAMOUSO.
$(eval $(call library,relay,$(wildcard relay/*.cc relay/layers/*.cc relay/famouso/*.cc)))
$(eval $(call program,mlcca-relay,relay/program/main.cc,$O/librelay.a $O/libcontrol.a $O/libbase.a,-lfmt))
PROGRAMS += $O/mlcca-relay
$(eval $(call program,mlcca-famouso,$(wildcard relay/famouso/program/*.cc),$O/librelay.a $O/libclient.a $O/librelay.a $O/libcontrol.a $O/libdescription.a $O/libcore.a $O/libbase.a,$(XML_LIBS) -lfmt))
PROGRAMS += $O/mlcca-famouso
