/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* What a socket buffer says about itself: the CAN frame in it and where it comes from. */
#ifndef MLCCA_GATE_FRAME_BPF_H
#define MLCCA_GATE_FRAME_BPF_H

#include "bpf/lead.bpf.h"

struct frame {
	__u32 can_id;
	__u32 len;	  /* payload bytes */
	__u32 format;	  /* GATE_CLASSIC, GATE_FD or GATE_XL */
	__u32 mark;	  /* when the gate saw it first */
	__u32 source;	  /* as source_of(); GATE_NO_SOURCE at ingress */
	__u32 generation; /* of the verdicts that it is decided by */
	__u32 read;	  /* sum of what was read for that: see moved_on() */
	/* J1939, see gate_transport.bpf.h: set where `transport` is. */
	__u32 transport; /* TRANSPORT_NONE unless it carries a part of a message that passes */
	__u32 message;	 /* identifier of the message that it announces */
	__u32 size;	 /* bytes of that message */
};

/* First words of struct can_frame and struct canfd_frame. */
struct frame_head {
	__u32 can_id;
	__u8 len;
	__u8 rest[3];
} __attribute__((aligned(8)));

/*
 * First words of struct canxl_frame, which the headers of older kernels lack. The identifier is the
 * 11-bit priority; the network's number (VCID) stands beside it.
 */
struct xl_head {
	__u32 prio;
	__u8 flags;
	__u8 sdt;
	__u16 len;
} __attribute__((aligned(8)));

#define XL_HEADER   12
#define XL_MAX_DLEN 2048
#define XL_FLAG	    0x80
#define XL_ID_MASK  0x00ff07ffU

/* The first eight bytes of a frame; CAN buffers are linear. */
static __always_inline bool load_head(struct __sk_buff *skb, __u32 lead, void *head)
{
	if (direct_access) {
		__u64 *data = (void *)(long)skb->data + lead;

		if ((void *)(data + 1) > (void *)(long)skb->data_end)
			return false;
		*(__u64 *)head = *data;
		return true;
	}
	return !bpf_skb_load_bytes(skb, lead, head, sizeof(__u64));
}

static __always_inline bool is_xl(struct __sk_buff *skb, __u32 lead, struct xl_head *head)
{
	return load_head(skb, lead, head) && head->flags & XL_FLAG && head->len &&
	       head->len <= XL_MAX_DLEN && skb->len == lead + XL_HEADER + head->len;
}

/* The length does not say whether a header stands in front. A frame that could be both is neither.
 */
static __always_inline bool read_xl(struct __sk_buff *skb, __u32 direction, struct frame *frame)
{
	struct xl_head bare, led;
	bool is_bare = is_xl(skb, 0, &bare);
	bool is_led = direction == GATE_INGRESS && is_xl(skb, XL_LEAD, &led);

	if (is_bare == is_led)
		return false;
	frame->can_id = is_bare ? bare.prio : led.prio;
	frame->len = is_bare ? bare.len : led.len;
	frame->format = GATE_XL;
	return !(frame->can_id & ~XL_ID_MASK);
}

/* False: not a frame of the right size. */
static __always_inline bool read_frame(struct __sk_buff *skb, __u32 direction, struct frame *frame)
{
	__u32 protocol = protocol_of(skb);
	struct frame_head head;
	__u32 limit, lead;

	if (protocol == bpf_htons(ETH_P_CAN)) {
		frame->format = GATE_CLASSIC;
		limit = CAN_MAX_DLEN;
		lead = skb->len - CAN_MTU;
	} else if (protocol == bpf_htons(ETH_P_CANFD)) {
		frame->format = GATE_FD;
		limit = CANFD_MAX_DLEN;
		lead = skb->len - CANFD_MTU;
	} else {
		return protocol == bpf_htons(XL_PROTOCOL) && read_xl(skb, direction, frame);
	}
	if (lead && (direction == GATE_EGRESS || !is_lead(lead)))
		return false;
	if (!load_head(skb, lead, &head))
		return false;
	frame->can_id = head.can_id;
	frame->len = head.len;
	return frame->len <= limit;
}

/*
 * Egress: 0 for a local program, else the ifindex that the frame came in by. That the ingress gate
 * there has passed it is what its mark must say: a frame from an interface without a gate, or the
 * echo of a local program's frame, has none.
 */
static __always_inline __u32 source_of(struct __sk_buff *skb)
{
	__u32 from = skb->ingress_ifindex;

	if (is_local(skb))
		return 0;
	return from ? from : GATE_NO_SOURCE;
}

#endif
