/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Finds the event in a MAC frame of IEEE 802.15.4. The kernel passes it from the frame control
 * field on, in both directions, without the frame check sequence. Numbers are little-endian.
 */
#ifndef MLCCA_ETHER_WPAN_BPF_H
#define MLCCA_ETHER_WPAN_BPF_H

/* The frame control field. */
#define WPAN_TYPE	7
#define WPAN_SECURED	0x0008
#define WPAN_ONE_PAN	0x0040 /* PAN ID compression: the source has the PAN of the destination */
#define WPAN_TO(c)	((c) >> 10 & 3)
#define WPAN_VERSION(c) ((c) >> 12 & 3)
#define WPAN_FROM(c)	((c) >> 14 & 3)

#define WPAN_BEACON  0
#define WPAN_DATA    1
#define WPAN_ACK     2
#define WPAN_COMMAND 3

/* Addressing modes; 1 is reserved. */
#define WPAN_NONE     0
#define WPAN_SHORT    2
#define WPAN_EXTENDED 3

#define WPAN_ADDRESSES 3 /* offset: after frame control and sequence number */
#define WPAN_NEWEST    1 /* newest known frame version (2006); later ones may have other fields */
#define WPAN_FIRST_GROUP                                                                           \
	0xfffe /* short addresses that no station has: none assigned, broadcast                    \
		*/

#define WPAN_LE16(x) bpf_ntohs(__builtin_bswap16(x))
#define WPAN_LE64(x) bpf_be64_to_cpu(__builtin_bswap64(x))

/*
 * Reads the sender at *at, and moves *at behind it. `pan`: PAN of the destination, if it has one.
 */
static __always_inline enum nature take_wpan_station(const struct packet *p, __u16 control,
						     __u16 pan, __u32 *at, struct event *e)
{
	__u16 number;
	__u64 address;

	if (!(control & WPAN_ONE_PAN)) {
		if (!TAKE(p, *at, &number))
			return MALFORMED;
		pan = WPAN_LE16(number);
		*at += sizeof(number);
	}
	if (WPAN_FROM(control) == WPAN_SHORT) {
		if (!TAKE(p, *at, &number) || WPAN_LE16(number) >= WPAN_FIRST_GROUP)
			return MALFORMED;
		*at += sizeof(number);
		e->station = ETHER_SHORT | (__u64)pan << 16 | WPAN_LE16(number);
		return EVENT;
	}
	if (!TAKE(p, *at, &address) || WPAN_LE64(address) & ETHER_EXTENDED)
		return MALFORMED;
	*at += sizeof(address);
	e->station = ETHER_EXTENDED | WPAN_LE64(address);
	return EVENT;
}

static __always_inline enum nature parse_wpan(const struct packet *p, struct event *e)
{
	__u32 at = WPAN_ADDRESSES;
	__u16 control, pan = 0;
	__be64 subject;

	if (!TAKE(p, 0, &control))
		return MALFORMED;
	control = WPAN_LE16(control);
	switch (control & WPAN_TYPE) {
	/* Frames by which a PAN organises itself are not affected. */
	case WPAN_BEACON:
	case WPAN_ACK:
	case WPAN_COMMAND:
		return NOT_EVENT;
	case WPAN_DATA:
		break;
	default:
		return OPAQUE;
	}
	if (control & WPAN_SECURED || WPAN_VERSION(control) > WPAN_NEWEST)
		return OPAQUE;
	if (WPAN_TO(control) == 1 || WPAN_FROM(control) == 1)
		return MALFORMED;
	if (control & WPAN_ONE_PAN && (!WPAN_TO(control) || !WPAN_FROM(control)))
		return MALFORMED;
	if (WPAN_TO(control) != WPAN_NONE) {
		if (!TAKE(p, at, &pan))
			return MALFORMED;
		pan = WPAN_LE16(pan);
		at += sizeof(pan) + (WPAN_TO(control) == WPAN_SHORT ? 2 : 8);
	}
	if (WPAN_FROM(control) != WPAN_NONE && take_wpan_station(p, control, pan, &at, e) != EVENT)
		return MALFORMED;
	if (!TAKE(p, at, &subject))
		return MALFORMED;
	e->subject = bpf_be64_to_cpu(subject);
	e->len = p->len - at - sizeof(subject);
	e->form = ETHER_UNFRAGMENTED;
	return EVENT;
}

#endif
