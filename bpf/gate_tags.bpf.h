/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * FAMOUSO: what the broker's replies say is held against the bindings that are stated here. See
 * struct gate_binding. Only frames of etag 4 come here.
 */
#ifndef MLCCA_GATE_TAGS_BPF_H
#define MLCCA_GATE_TAGS_BPF_H

/* REPLIES wake-ups at once, then one in REPLY_NS. The table holds what they report. */
#define REPLIES	 16
#define REPLY_NS 100000000ULL

/* A reply is two of these: the node that asked, first or second half, the tag, half a subject. */
struct reply_frame {
	__u8 node;
	__u8 half;
	__u16 etag;
	__u32 part;
};

struct reply {
	__u64 subject; /* of both halves, where they are known */
	__u32 part;
	__u32 half;
	__u32 etag;
	__u32 whole;  /* `subject` is */
	__u32 broker; /* both halves are as a broker sends them, and control traffic */
	__u32 news;   /* something about a binding was found */
};

static __always_inline __u32 half_of(__u64 subject, __u32 half)
{
	return half ? (__u32)subject : (__u32)(subject >> 32);
}

/*
 * The slots of a binding refuse from now on. After the count of contradictions: who reads that
 * after linking a slot sees this one, or this walk sees the slot.
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

/* The tag is dealt to a subject of which one half at least is another one. */
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

/* The subject is dealt a tag. */
static __always_inline void deal(struct gate_binding *b, struct reply *r)
{
	if (r->broker && b->dealt != r->etag) {
		WRITE_ONCE(b->dealt, r->etag);
		r->news = 1;
	}
	if (!b->etag)
		return;
	if (b->etag != r->etag) {
		/* To whom its tag was dealt says more, where that is known. */
		if (b->contradictions == b->settled)
			WRITE_ONCE(b->halves, 0);
		contradict(b, r);
	} else if (r->broker && b->contradictions != b->settled) {
		WRITE_ONCE(b->confirmed, b->contradictions);
		r->news = 1;
	}
}

/*
 * A tag that the subject was dealt, and which user space has not stated yet, is another one's now.
 * Counted, so that user space, which may just be stating it, finds a contradiction.
 */
static __always_inline void take_back(struct gate_binding *b, struct reply *r)
{
	WRITE_ONCE(b->dealt, 0);
	__sync_fetch_and_add(&b->contradictions, 1);
	r->news = 1;
}

static long look_at_binding(__u32 at, void *context)
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

/* The first half of a reply wakes no reader: at the second one the whole subject is known.
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
 * Joins the second half of a reply to the first one for the same node. A reply of which one half is
 * not the broker's binds nothing new.
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
 * What comes in has been on the bus, whatever becomes of it here; what goes out comes here when it
 * passes, also by audit mode. `admitted`: as control traffic. A reply that no broker may send
 * closes as well: nodes take the answer from any sender. Not static: the verifier checks it once
 * by itself.
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
	bpf_loop(READ_ONCE(table.bindings_end), look_at_binding, &r, 0);
	if (r.news)
		report_news(r.half);
	return 0;
}

static __always_inline bool is_reply(const struct frame *frame)
{
	return profile == GATE_PROFILE_FAMOUSO &&
	       (frame->can_id & (CAN_EFF_FLAG | GATE_ETAG_MASK)) == (CAN_EFF_FLAG | GATE_REPLY_TAG);
}

#endif
