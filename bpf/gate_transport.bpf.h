/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Messages that J1939's transport protocol carries, see gate_transport.h. An announcement is
 * decided like a frame of the PGN that it names, with the format GATE_TRANSPORT and the length of
 * the message. Each packet is decided again: as a frame of the message that its source has
 * announced, in order. So if a slot is closed or removed, the message ends with the next packet,
 * and a sender that the slot does not name cannot add to it. Everything else with these PGNs is
 * control traffic, which is decided by its own key. Only frames with these PGNs are passed to these
 * functions.
 */
#ifndef MLCCA_GATE_TRANSPORT_BPF_H
#define MLCCA_GATE_TRANSPORT_BPF_H

/* Values of frame.transport. */
#define TRANSPORT_NONE	   0
#define TRANSPORT_PACKET   1
#define TRANSPORT_ANNOUNCE 2 /* with the number of packets from bit 8 on */

static __always_inline bool is_transport(const struct frame *frame)
{
	__u32 pgn = frame->can_id & GATE_TP_PGN_MASK;

	return (pgn == GATE_TP_CM || pgn == GATE_TP_DT) && (frame->can_id & CAN_EFF_FLAG);
}

static __always_inline struct gate_session *session_of(const struct frame *frame, __u32 direction)
{
	return &table.sessions[direction & (GATE_DIRECTIONS - 1)][frame->can_id & GATE_TP_SOURCE];
}

static __always_inline __u64 session_state(__u32 id, __u32 slot, __u32 packets, __u32 next)
{
	return (__u64)next << 56 | (__u64)packets << 48 | (__u64)(slot & (GATE_SLOTS - 1)) << 32 |
	       (id & (CAN_EFF_MASK & ~GATE_TP_PRIORITY));
}

/* Turns the frame into one of the message, with the frame's own priority. */
static __always_inline void make_message(struct frame *frame, __u32 id, __u32 len)
{
	frame->can_id = (frame->can_id & (CAN_EFF_FLAG | GATE_TP_PRIORITY)) | id;
	frame->format = GATE_TRANSPORT;
	frame->len = len;
}

/*
 * Decides about an announcement: `frame` gets the identifier and size of the announced message.
 * GATE_R_UNKNOWN: the message belongs to no channel.
 */
static __always_inline __u64 judge_announcement(struct __sk_buff *skb, struct frame *frame,
						__u32 direction, const __u8 *data)
{
	__u32 size = data[1] | data[2] << 8, pgn = data[5] | data[6] << 8 | data[7] << 16,
	      id = pgn << 8 | (frame->can_id & GATE_TP_SOURCE),
	      destination = frame->can_id & GATE_TP_DESTINATION;
	struct frame message = *frame;
	__u64 found;

	frame->message = frame->can_id;
	if (pgn >> 18)
		return packed(GATE_R_MALFORMED, direction);
	if ((id & GATE_J1939_PDU2) != GATE_J1939_PDU2) {
		if (pgn & 0xff)
			return packed(GATE_R_MALFORMED, direction);
		id |= destination;
	}
	make_message(&message, id, size);
	found = decide_again(skb, &message, direction);
	frame->message = message.can_id;
	if (found >> 32 != GATE_R_PASSED)
		return found;
	/* A request to send is answered by frames of other nodes, which no slot admits. */
	if (data[0] != GATE_TP_BAM || destination != GATE_TP_BROADCAST)
		return packed(GATE_R_FORMAT, found);
	if (size > GATE_TP_MOST)
		return packed(GATE_R_LENGTH, found);
	if (size < GATE_TP_LEAST || data[3] != (size + GATE_TP_PACKET - 1) / GATE_TP_PACKET)
		return packed(GATE_R_MALFORMED, direction);
	frame->message = id;
	frame->size = size;
	frame->transport = TRANSPORT_ANNOUNCE | (__u32)data[3] << 8;
	return found;
}

/* Decides about a packet. GATE_R_UNKNOWN: its source has announced no message. */
static __always_inline __u64 judge_packet(struct __sk_buff *skb, struct frame *frame,
					  __u32 direction, __u32 number)
{
	struct gate_session *session = session_of(frame, direction);
	__u64 state = READ_ONCE(session->state), now = bpf_ktime_get_ns(), found;
	__u32 slot = state >> 32 & (GATE_SLOTS - 1), packets = state >> 48 & 0xff;
	struct frame message = *frame;

	if (!state || now - READ_ONCE(session->latest) > GATE_TP_TIMEOUT)
		return packed(GATE_R_UNKNOWN, direction);
	make_message(&message, state & CAN_EFF_MASK, GATE_TP_LEAST);
	frame->message = message.can_id;
	found = decide_again(skb, &message, direction);
	if (found >> 32 != GATE_R_PASSED)
		return found >> 32 == GATE_R_UNKNOWN ? packed(GATE_R_FRAGMENT, direction) : found;
	if ((__u32)found != slot)
		return packed(GATE_R_SOURCE, found);
	if (number != state >> 56 || (frame->can_id & GATE_TP_DESTINATION) != GATE_TP_BROADCAST)
		return packed(GATE_R_FRAGMENT, found);
	if (__sync_val_compare_and_swap(&session->state, state,
					number == packets ? 0 : state + (1ULL << 56)) != state)
		return packed(GATE_R_FRAGMENT, found);
	WRITE_ONCE(session->latest, now);
	frame->transport = TRANSPORT_PACKET;
	return found;
}

/*
 * Ends the former message of the source, for all that have seen the announcement: at ingress all
 * nodes have, at egress only if the announcement passes.
 */
static __always_inline void end_session(const struct frame *frame, __u32 direction)
{
	WRITE_ONCE(session_of(frame, direction)->state, 0);
}

/* Not static, so that the verifier checks it once. */
__noinline __u64 judge_transport(struct __sk_buff *skb, struct frame *frame, __u32 direction)
{
	__u64 found = packed(GATE_R_UNKNOWN, direction), own;
	bool announces = false;
	__u8 data[CAN_MAX_DLEN];

	direction &= GATE_DIRECTIONS - 1;
	if (!frame)
		return packed(GATE_R_UNKNOWN, direction);
	if (frame->format == GATE_CLASSIC && frame->len == CAN_MAX_DLEN &&
	    !(frame->can_id & CAN_RTR_FLAG) &&
	    !bpf_skb_load_bytes(skb, skb->len - CAN_MAX_DLEN, data, sizeof(data))) {
		if ((frame->can_id & GATE_TP_PGN_MASK) == GATE_TP_DT) {
			found = judge_packet(skb, frame, direction, data[0]);
		} else if (data[0] == GATE_TP_BAM || data[0] == GATE_TP_RTS) {
			announces = data[0] == GATE_TP_BAM;
			found = judge_announcement(skb, frame, direction, data);
		}
	}
	if (announces && direction == GATE_INGRESS)
		end_session(frame, direction);
	/* Another sender and what can be no message have the message's identifier in reports. */
	if (found >> 32 == GATE_R_IDENTIFIER || found >> 32 == GATE_R_SOURCE ||
	    found >> 32 == GATE_R_MALFORMED)
		frame->can_id = frame->message;
	if (found >> 32 == GATE_R_IDENTIFIER &&
	    is_elsewhere(&table.slots[found & (GATE_SLOTS - 1)], frame->message))
		return packed(GATE_R_UNKNOWN, direction);
	if (found >> 32 != GATE_R_UNKNOWN)
		return found;
	own = decide_again(skb, frame, direction);
	if (own >> 32 == GATE_R_PASSED) {
		if (announces)
			end_session(frame, direction);
		return own;
	}
	/* An unknown announcement is reported with the announced PGN; a single packet has none. */
	if (announces) {
		frame->can_id = frame->message;
		return found;
	}
	if ((frame->can_id & GATE_TP_PGN_MASK) == GATE_TP_DT)
		return packed(GATE_R_FRAGMENT, own);
	return own;
}

/* Like admit(): the announcement pays for all frames and bytes of the message. */
static __always_inline bool admit_transport(struct gate_cpu *cpu, __u32 direction, __u32 at,
					    const struct frame *frame)
{
	struct gate_slot *slot = &table.slots[at & (GATE_SLOTS - 1)];
	struct gate_watch *w = &table.watches[at & (GATE_SLOTS - 1)];
	struct gate_session *session = session_of(frame, direction);
	__u32 packets = frame->transport >> 8 & 0xff;
	__u64 cost, period, now;

	if (frame->transport == TRANSPORT_PACKET) {
		count_pass(cpu, direction, at, frame);
		return true;
	}
	cost = cost_of(READ_ONCE(slot->per_frame) * (packets + 1), READ_ONCE(slot->per_byte),
		       frame->size);
	period = READ_ONCE(w->period);
	now = bpf_ktime_get_ns();
	if (!police(cpu, at, cost, now))
		return false;
	WRITE_ONCE(session->latest, now);
	store_in_order(&session->state, session_state(frame->message, at, packets, 1));
	count_pass(cpu, direction, at, frame);
	if (period)
		watch(w, period, now);
	return true;
}

#endif
