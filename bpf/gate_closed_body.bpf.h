/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * The program of a CAN interface before a daemon runs: it passes only what a closed gate passes. It
 * has no tables and counters, so that the kernel verifies it quickly.
 */
#ifndef MLCCA_GATE_CLOSED_BODY_BPF_H
#define MLCCA_GATE_CLOSED_BODY_BPF_H

#include "bpf/gate.h"
#include "bpf/once.bpf.h"

struct gate_control control SEC(".data.control"); /* shared by all interfaces */

#define direct_access false

#include "bpf/gate_frame.bpf.h"

static __always_inline int refuse(struct __sk_buff *skb)
{
	skb->mark = 0; /* whoever set it: nothing was granted here */
	return READ_ONCE(control.mode) == GATE_AUDIT ? TC_ACT_UNSPEC : TC_ACT_SHOT;
}

SEC("tc")
int closed_ingress(struct __sk_buff *skb)
{
	struct frame frame;

	/* an echo or an error frame */
	if (is_local(skb) ||
	    (read_frame(skb, GATE_INGRESS, &frame) && frame.can_id & CAN_ERR_FLAG)) {
		skb->mark = 0;
		return TC_ACT_UNSPEC;
	}
	return refuse(skb);
}

SEC("tc")
int closed_egress(struct __sk_buff *skb) { return refuse(skb); }

#endif
