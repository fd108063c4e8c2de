/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Replaces skb.bpf.h in objects that only tests load. BPF_PROG_TEST_RUN can make neither ETH_P_CAN
 * nor a buffer with a socket. So the protocol follows from the length, and the priority states
 * whether a frame is sent locally or is CAN XL.
 */
#ifndef MLCCA_SKB_BPF_H
#define MLCCA_SKB_BPF_H

#include "bpf/lead.bpf.h"

#define TEST_RUN_LOCAL 1
#define TEST_RUN_XL    2

static __always_inline __u32 protocol_of(struct __sk_buff *skb)
{
	if (skb->priority & TEST_RUN_XL)
		return bpf_htons(XL_PROTOCOL);
	if (is_lead(skb->len - CAN_MTU))
		return bpf_htons(ETH_P_CAN);
	return is_lead(skb->len - CANFD_MTU) ? bpf_htons(ETH_P_CANFD) : 0;
}

static __always_inline bool is_local(struct __sk_buff *skb)
{
	return skb->priority & TEST_RUN_LOCAL;
}

#endif
