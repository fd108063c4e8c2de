/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Whether the gates are closed: by the daemon, by the kernel timer, or because the deadline of the
 * last heart-beat is over. The deadline is compared for each frame, so that closing needs neither a
 * timer nor a pin; it is kept in jiffies, which cost a nanosecond to read (CLOCK_MONOTONIC: 35).
 */
#ifndef MLCCA_CLOSED_BPF_H
#define MLCCA_CLOSED_BPF_H

struct gate_control control SEC(".data.control"); /* shared by all interfaces */

static __always_inline bool closed(void)
{
	return !READ_ONCE(control.open) || READ_ONCE(control.lapsed) ||
	       bpf_jiffies64() > READ_ONCE(control.deadline);
}

#endif
