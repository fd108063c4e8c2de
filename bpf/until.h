/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
#ifndef MLCCA_UNTIL_H
#define MLCCA_UNTIL_H

#include <linux/types.h>

/*
 * Until when the gates may be open, whatever heart-beats arrive: later, what they pass is not
 * reserved for this gateway any more. It is in a map of its own, which only gate_beat reads.
 */
struct gate_until {
	__u64 until; /* CLOCK_MONOTONIC ns; 0: as long as heart-beats arrive */
	__u64 tick;  /* ns of one jiffy */
};

#endif
