/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * FAMOUSO: compares the broker's replies with the stated bindings, see struct gate_binding. Only
 * frames with etag 4 are passed to it.
 */
#ifndef MLCCA_GATE_TAGS_BPF_H
#define MLCCA_GATE_TAGS_BPF_H

/* At most REPLIES wake-ups at once, then one in REPLY_NS. The table has what they report. */
#define REPLIES	 16
#define REPLY_NS 100000000ULL

/* A reply has two of these: the asking node, first or second half, the tag, half of a subject. */
struct reply_frame {
	__u8 node;
	__u8 half;
	__u16 etag;
	__u32 part;
};

struct reply {
	__u64 subject; /* from both halves, if both are known */
	__u32 part;
	__u32 half;
	__u32 etag;
	__u32 whole;  /* `subject` is complete */
	__u32 broker; /* both halves have a broker's form and are admitted as control traffic */
	__u32 news;   /* something about a binding was found */
};

static __always_inline __u32 half_of(__u64 subject, __u32 half)
{
	return half ? (__u32)subject : (__u32)(subject >> 32);
}

/*
 * Makes the slots of a binding refuse. It must follow the count of contradictions: a reader that
 * links a slot and then reads the count sees this one, or this walk sees the slot.
 */
static __always_inline void shut(__u32 etag, __u64 subject)
{
	__u32 direction, at, i;

	for (direction = 0; direction < GATE_DIRECTIONS; direction++) {
		at = READ_ONCE(table.head[direction][etag & GATE_ETAG_MASK]);
		for (i = 0; i < GATE_WALK && at; i++) {
			struct gate_slot *slot = &table.slots[at & (GATE_SLOTS - 1)];

			if (slot->subject == subject ||
			    (!slot->subject && subject == GATE_SUBSCRIBE))
				WRITE_ONCE(slot->contradicted, 1);
			at = READ_ONCE(slot->next);
		}
	}
}

static __always_inline void contradict(struct gate_binding *b, struct reply *r)
{
	__sync_fetch_and_add(&b->contradictions, 1);
	shut(b->etag, b->subject);
	r->news = 1;
}

/* The tag was assigned to a subject of which at least one half differs. */
static __always_inline void deal_to_another(struct gate_binding *b, struct reply *r)
{
	if (r->whole) {
		WRITE_ONCE(b->other, r->subject);
		WRITE_ONCE(b->halves, 3);
	} else {
		WRITE_ONCE(b->other, r->half ? r->part : (__u64)r->part << 32);
		WRITE_ONCE(b->halves, 1 << r->half);
	}
	if (b->dealt == b->etag)
		WRITE_ONCE(b->dealt, 0);
	contradict(b, r);
}

/* The subject was assigned a tag. */
static __always_inline void deal(struct gate_binding *b, struct reply *r)
{
	if (r->broker && b->dealt != r->etag) {
		WRITE_ONCE(b->dealt, r->etag);
		r->news = 1;
	}
	if (!b->etag)
		return;
	if (b->etag != r->etag) {
		/* If it is known to whom the tag was assigned, that says more, so it is kept. */
		if (b->contradictions == b->settled)
			WRITE_ONCE(b->halves, 0);
		contradict(b, r);
	} else if (r->broker && b->contradictions != b->settled) {
		WRITE_ONCE(b->confirmed, b->contradictions);
		r->news = 1;
	}
}

/*
 * A tag that the subject was assigned, but that user space has not stated yet, now belongs to
 * another subject. It is counted, so that user space finds a contradiction if it is just stating
 * it.
 */
static __always_inline void take_back(struct gate_binding *b, struct reply *r)
{
	WRITE_ONCE(b->dealt, 0);
	__sync_fetch_and_add(&b->contradictions, 1);
	r->news = 1;
}

static long compare_binding(__u32 at, void *context)
{
	struct gate_binding *b = &table.bindings[at & (GATE_BINDINGS - 1)];
	struct reply *r = context;

	if (!b->subject)
		return 0;
	if (b->etag && b->etag == r->etag && half_of(b->subject, r->half) != r->part)
		deal_to_another(b, r);
	else if (b->dealt && b->dealt == r->etag && half_of(b->subject, r->half) != r->part)
		take_back(b, r);
	else if (r->whole && b->subject == r->subject)
		deal(b, r);
	return 0;
}

/*
 * Reports a finding. The first half of a reply wakes no reader, because only the second one makes
 * the subject known.
 */
static __always_inline void report_news(__u32 half)
{
	struct gate_event event = {.kind = GATE_E_BOUND, .ifindex = ifindex};

	__sync_fetch_and_add(&table.binding_news, 1);
	if (!half ||
	    !take_turn(&table.reply_due, REPLY_NS, (REPLIES - 1) * REPLY_NS,
		       bpf_ktime_get_coarse_ns()) ||
	    bpf_ringbuf_query(&events, BPF_RB_AVAIL_DATA) >= GATE_EVENTS_SIZE / 2)
		return;
	event.at = bpf_ktime_get_ns();
	bpf_ringbuf_output(&events, &event, sizeof(event), 0);
}

/*
 * Joins the second half of a reply to the first one for the same node. If one half is not the
 * broker's, the reply confirms nothing.
 */
static __always_inline void join(struct reply *r, __u32 direction, __u32 node)
{
	struct gate_half *first = &table.halves[direction & 1][node & (GATE_ASKERS - 1)];

	if (!r->half) {
		first->part = r->part;
		first->etag = r->etag;
		first->broker = r->broker;
		first->there = 1;
		return;
	}
	r->whole = first->there && first->etag == r->etag;
	r->subject = (__u64)first->part << 32 | r->part;
	r->broker = r->broker && r->whole && first->broker;
	first->there = 0;
}

/*
 * Takes a reply. At ingress it has been on the bus, whatever is decided here; at egress it is
 * passed to this function if it passes, also in audit mode. `admitted`: as control traffic. A reply
 * that no broker may send contradicts as well, because nodes accept answers from any sender. It is
 * not static, so that the verifier checks it once.
 */
__noinline __u32 heed_reply(struct __sk_buff *skb, struct frame *frame, __u32 direction,
			    __u32 admitted)
{
	struct reply_frame data;
	struct reply r = {};

	if (!frame || frame->format != GATE_CLASSIC || frame->len != CAN_MAX_DLEN ||
	    frame->can_id & (CAN_RTR_FLAG | CAN_ERR_FLAG))
		return 0;
	if (bpf_skb_load_bytes(skb, skb->len - CAN_MAX_DLEN, &data, sizeof(data)) || data.half > 1)
		return 0;
	r.half = data.half;
	r.etag = bpf_ntohs(data.etag) & GATE_ETAG_MASK;
	r.part = bpf_ntohl(data.part);
	r.broker = admitted && (frame->can_id & CAN_EFF_MASK) == GATE_REPLY_ID;
	join(&r, direction, data.node);
	bpf_loop(READ_ONCE(table.bindings_end), compare_binding, &r, 0);
	if (r.news)
		report_news(r.half);
	return 0;
}

static __always_inline bool is_reply(const struct frame *frame)
{
	return gate_has_broker(profile) &&
	       (frame->can_id & (CAN_EFF_FLAG | GATE_ETAG_MASK)) == (CAN_EFF_FLAG | GATE_REPLY_TAG);
}

#endif
