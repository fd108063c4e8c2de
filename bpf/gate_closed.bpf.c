// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/*
 * What a CAN interface gets before there is a daemon: nothing passes but what passes a gate that is
 * closed as well. Without tables and counters: the kernel has checked it in no time.
 */
#include <stdbool.h>
#include <linux/bpf.h>
#include <linux/can.h>
#include <linux/if_ether.h>
#include <linux/pkt_cls.h>
#include <bpf/bpf_endian.h>
#include <bpf/bpf_helpers.h>

#include "bpf/gate.h"
#include "bpf/once.bpf.h"

struct gate_control control SEC(".data.control"); /* shared by all interfaces */

/* As in the gate. */
const volatile __u8 test_run = false;
#define TEST_RUN_LOCAL 1
#define TEST_RUN_XL    2
#define direct_access  false

#include "bpf/gate_frame.bpf.h"

static __always_inline int refuse(struct __sk_buff *skb)
{
	skb->mark = 0; /* whoever made it: nothing here was granted */
	return READ_ONCE(control.mode) == GATE_AUDIT ? TC_ACT_UNSPEC : TC_ACT_SHOT;
}

SEC("tc")
int closed_ingress(struct __sk_buff *skb)
{
	struct frame frame;

	/* An echo, or an error frame. */
	if (is_local(skb) ||
	    (read_frame(skb, GATE_INGRESS, &frame) && frame.can_id & CAN_ERR_FLAG)) {
		skb->mark = 0;
		return TC_ACT_UNSPEC;
	}
	return refuse(skb);
}

SEC("tc")
int closed_egress(struct __sk_buff *skb) { return refuse(skb); }

char LICENSE[] SEC("license") = "Dual BSD/GPL";
