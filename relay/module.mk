# SPDX-License-Identifier: BSD-2-Clause
# What carries events between networks: so far the protocols of FAMOUSO, without a program of their own.
$(eval $(call library,relay,$(wildcard relay/*.cc)))
