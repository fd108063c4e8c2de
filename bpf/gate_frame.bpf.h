/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/* Reads the CAN frame in a socket buffer and where it comes from. */
#ifndef MLCCA_GATE_FRAME_BPF_H
#define MLCCA_GATE_FRAME_BPF_H

#include "bpf/lead.bpf.h"

struct frame {
	__u32 can_id;
	__u32 len;	  /* payload bytes */
	__u32 format;	  /* GATE_CLASSIC, GATE_FD or GATE_XL */
	__u32 mark;	  /* its mark when the gate read it */
	__u32 source;	  /* source_of(); GATE_NO_SOURCE at ingress */
	__u32 generation; /* generation of verdicts used for the decision */
	__u32 read;	  /* sum of what was read for the decision, see moved_on() */
	/* J1939, see gate_transport.bpf.h; valid if `transport` is set. */
	__u32 transport; /* TRANSPORT_NONE unless it is part of a message that passes */
	__u32 message;	 /* identifier of the message that it announces or carries */
	__u32 size;	 /* bytes of that message */
};

/* The first words of struct can_frame and struct canfd_frame. */
struct frame_head {
	__u32 can_id;
	__u8 len;
	__u8 rest[3];
} __attribute__((aligned(8)));

/*
 * The first words of struct canxl_frame, which older kernel headers lack. The identifier is the
 * 11-bit priority; the number of the virtual network (VCID) is next to it.
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

/* Reads the first eight bytes of a frame; buffers of CAN are linear. */
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

/*
 * For reports: what can be read of a frame that has not the form that its network prescribes. Its
 * identifier is read where no lead can precede it, however short the frame is. Format 0: it is not
 * known.
 */
static __always_inline bool misshapen(struct __sk_buff *skb, __u32 direction, __u32 format,
				      struct frame *frame)
{
	__u32 can_id = 0;

	if (direction != GATE_EGRESS || bpf_skb_load_bytes(skb, 0, &can_id, sizeof(can_id)))
		format = 0;
	frame->can_id = format ? can_id : 0;
	frame->format = format;
	return false;
}

static __always_inline bool is_xl(struct __sk_buff *skb, __u32 lead, struct xl_head *head)
{
	return load_head(skb, lead, head) && head->flags & XL_FLAG && head->len &&
	       head->len <= XL_MAX_DLEN && skb->len == lead + XL_HEADER + head->len;
}

/*
 * Reads a CAN XL frame. Its length does not show whether a lead precedes it, so a frame that could
 * be both is refused.
 */
static __always_inline bool read_xl(struct __sk_buff *skb, __u32 direction, struct frame *frame)
{
	struct xl_head bare, led;
	bool is_bare = is_xl(skb, 0, &bare);
	bool is_led = direction == GATE_INGRESS && is_xl(skb, XL_LEAD, &led);

	if (is_bare == is_led)
		return misshapen(skb, direction, GATE_XL, frame);
	frame->can_id = is_bare ? bare.prio : led.prio;
	frame->len = is_bare ? bare.len : led.len;
	frame->format = GATE_XL;
	return !(frame->can_id & ~XL_ID_MASK);
}

/*
 * Returns false if it is not a frame of the right size. Then `frame` has only what misshapen()
 * finds, or its identifier and format.
 */
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
		return protocol == bpf_htons(XL_PROTOCOL) ? read_xl(skb, direction, frame)
							  : misshapen(skb, direction, 0, frame);
	}
	if ((lead && (direction == GATE_EGRESS || !is_lead(lead))) || !load_head(skb, lead, &head))
		return misshapen(skb, direction, frame->format, frame);
	frame->can_id = head.can_id;
	frame->len = head.len;
	return frame->len <= limit;
}

/*
 * Egress: 0 for a local program, otherwise the ifindex by which the frame entered. Its mark must
 * show that the ingress gate there has passed it: a frame from an interface without a gate, or the
 * echo of a local frame, has no such mark.
 */
static __always_inline __u32 source_of(struct __sk_buff *skb)
{
	__u32 from = skb->ingress_ifindex;

	if (is_local(skb))
		return 0;
	return from ? from : GATE_NO_SOURCE;
}

#endif
