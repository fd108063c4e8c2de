/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Whether a gate is closed: by the daemon, by the kernel timer, because no daemon holds it any
 * more, or because the deadline of the last heart-beat is over. The deadline is compared for each
 * frame, so that closing needs neither a timer nor a pin; it is kept in jiffies, which cost a
 * nanosecond to read (CLOCK_MONOTONIC: 35).
 */
#ifndef MLCCA_CLOSED_BPF_H
#define MLCCA_CLOSED_BPF_H

struct gate_control control SEC(".data.control"); /* shared by all interfaces */

/* `epoch`: of the table of the gate. */
static __always_inline bool closed(__u32 epoch)
{
	return !READ_ONCE(control.open) || READ_ONCE(control.lapsed) ||
	       epoch < READ_ONCE(control.epoch) || bpf_jiffies64() > READ_ONCE(control.deadline);
}

#endif
