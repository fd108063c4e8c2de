/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
#ifndef MLCCA_UNTIL_H
#define MLCCA_UNTIL_H

#include <linux/types.h>

/*
 * Until when the gates may be open, whatever heart-beats come: what they let pass is promised to
 * this gateway no longer. In a map of its own, which gate_beat alone reads.
 */
struct gate_until {
	__u64 until; /* CLOCK_MONOTONIC ns; 0: as long as heart-beats come */
	__u64 tick;  /* ns between two jiffies */
};

#endif
