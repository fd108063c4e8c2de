/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* What the kernel says of a socket buffer. test_skb.bpf.h says it in its place in test runs. */
#ifndef MLCCA_SKB_BPF_H
#define MLCCA_SKB_BPF_H

static __always_inline __u32 protocol_of(struct __sk_buff *skb) { return skb->protocol; }

/* Sent by a program on this machine. Forwarded frames and frames from the wire have no socket. */
static __always_inline bool is_local(struct __sk_buff *skb) { return skb->sk != 0; }

#endif
