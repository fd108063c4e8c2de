/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Whether a gate is closed: by the daemon, by the kernel timer, because its epoch is over (no
 * daemon holds it), or because the deadline of the last heart-beat has passed. Each frame compares
 * the deadline, so that closing needs neither a timer nor a pin. The deadline is in jiffies, which
 * take a nanosecond to read (CLOCK_MONOTONIC: 35 ns).
 */
#ifndef MLCCA_CLOSED_BPF_H
#define MLCCA_CLOSED_BPF_H

struct gate_control control SEC(".data.control"); /* shared by all interfaces */

/* `epoch`: that of the gate's table. */
static __always_inline bool closed(__u32 epoch)
{
	return !READ_ONCE(control.open) || READ_ONCE(control.lapsed) ||
	       epoch < READ_ONCE(control.epoch) || bpf_jiffies64() > READ_ONCE(control.deadline);
}

#endif
