/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* What the kernel states about a socket buffer. In test runs test_skb.bpf.h replaces this file. */
#ifndef MLCCA_SKB_BPF_H
#define MLCCA_SKB_BPF_H

static __always_inline __u32 protocol_of(struct __sk_buff *skb) { return skb->protocol; }

/* Whether a program on this machine sent it; forwarded and received frames have no socket. */
static __always_inline bool is_local(struct __sk_buff *skb) { return skb->sk != 0; }

#endif
