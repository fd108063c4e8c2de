/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * What the gate programs and user space share. Every size is asserted on both sides; a change of
 * any layout here needs a new GATE_LAYOUT_VERSION, which is part of the pin path.
 */
#ifndef MLCCA_GATE_H
#define MLCCA_GATE_H

#include <linux/can.h>
#include <linux/types.h>

#include "bpf/gate_binding.h"
#include "bpf/gate_transport.h"

#define GATE_LAYOUT_VERSION 9

/* Our tc filters: this priority and handle belong to the gate, and nothing else is ever replaced.
 */
#define GATE_TC_PRIORITY 1
#define GATE_TC_HANDLE	 0x4d4c4343 /* "MLCC" */

#define GATE_INGRESS	0
#define GATE_EGRESS	1
#define GATE_DIRECTIONS 2

/* Slots of one interface, both directions. 0 and 1 count what has no slot, per direction. */
#define GATE_SLOTS	4096
#define GATE_FIRST_SLOT 2

/* Slots that may share one key (publishers of one subject on one interface). */
#define GATE_CHAIN 8
/* Decisions of one frame that a change of generation may undo; then it is denied. */
#define GATE_TRIES 32
/*
 * Slots of one bucket that the program walks: several 29-bit identifiers may hash together. So many
 * masked slots a direction has at most.
 */
#define GATE_WALK 32

/*
 * Buckets of one direction. An 11-bit identifier is its own bucket; a 29-bit one (raw) or a PGN
 * (j1939) hashes into the 14 bits behind them. An etag (famouso) or subject-id (cyphal) is the
 * bucket.
 */
#define GATE_STANDARD_BUCKETS 2048
#define GATE_HASH_BITS	      14
#define GATE_BUCKETS	      (GATE_STANDARD_BUCKETS + (1 << GATE_HASH_BITS))
#define GATE_NO_BUCKET	      0xffffffffU
#define GATE_ETAG_MASK	      0x3fffU

/*
 * SAE J1939-21: priority, extended data page, data page, PDU format, PDU specific, source address.
 * The PGN is everything between priority and source; below PDU format 240 (PDU1) PDU specific is
 * the destination and no part of it.
 */
#define GATE_J1939_PDU1_KEY 0x03ff0000U
#define GATE_J1939_PDU2_KEY 0x03ffff00U
#define GATE_J1939_PDU2	    0x00f00000U /* PDU format of 240 and more has all of these */

/*
 * Cyphal/CAN 1.0: priority, service, anonymous, reserved (0), two bits that receivers ignore,
 * subject-id, reserved (0), source. Frames of services and with a reserved bit have no key.
 */
#define GATE_CYPHAL_KEY	    0x001fff00U
#define GATE_CYPHAL_SHIFT   8
#define GATE_CYPHAL_FOREIGN (1U << 25 | 1U << 23 | 1U << 7)

#define GATE_SEEN 64 /* last seen frames without a slot, per CPU; power of two */

/*
 * Gaps between the events of a slot, by eighths of its period: [n] counts those of n to n + 1
 * eighths, the last one what is longer. From 12 on (one and a half) an event is missing in between.
 */
#define GATE_GAPS	  16
#define GATE_GAPS_PERIOD  8
#define GATE_GAPS_MISSING 12
#define GATE_GAP_BITS	  56 /* of gap * scale behind the point */
/*
 * A gap as long as `silence` of its watch, or as so many periods where that is 0, and no shorter
 * than GATE_RECOVERY_HOLD, is a silence: what was found starts over with the event that ends it.
 */
#define GATE_SILENT_PERIODS 16
#define GATE_LONGEST_PERIOD (1ULL << 50) /* ns, 13 days: longer ones are not watched */

#define GATE_SILENCE_TIMERS 16 /* timers of one interface; each supervises every 16th slot */
#define GATE_RECOVERY_HOLD                                                                         \
	1000000000ULL		      /* ns for which events come again before that is reported */
#define GATE_EVENTS_SIZE (256 * 1024) /* bytes of the ring of gate_event and gate_sample */

/* Samples of frames without a slot, for each interface: so many at once, then one in that time. */
#define GATE_SAMPLES   16
#define GATE_SAMPLE_NS 1000000000ULL

/* Bands of the prio queueing discipline behind a gate, the first one is served first. */
#define GATE_BANDS 16

#define GATE_ANY_UID 0xffffffffU
/*
 * Source of a frame that came by no interface and belongs to no socket: the kernel made it (the
 * transport protocol of can-j1939).
 */
#define GATE_NO_SOURCE 0xffffffffU

enum gate_profile {
	GATE_PROFILE_NONE = 0,	  /* no frame names a subject: everything is unknown */
	GATE_PROFILE_RAW = 1,	  /* key: the identifier, 11 or 29 bits */
	GATE_PROFILE_FAMOUSO = 2, /* 29-bit only; key: the low 14 bits */
	GATE_PROFILE_J1939 = 3,	  /* 29-bit only; key: the 18-bit PGN */
	GATE_PROFILE_CYPHAL = 4,  /* 29-bit messages only; key: the 13-bit subject-id */
	GATE_PROFILE_CANOPEN = 5, /* 11-bit only; key: the COB-ID */
};

enum gate_verdict {
	GATE_DENY = 0,
	GATE_PASS = 1,
};

enum gate_mode {
	GATE_ENFORCE = 0,
	GATE_AUDIT = 1, /* drop nothing, and count apart what would be dropped */
};

/* Frame formats of a slot, a bit set. */
#define GATE_CLASSIC 1
#define GATE_FD	     2
#define GATE_XL	     8 /* identifier: the 11-bit priority */
/*
 * J1939: messages of 9 to max_len bytes as well, by the transport protocol. A frame alone has no
 * more than its own format holds.
 */
#define GATE_TRANSPORT 16
/* In the same bits: frames beyond the admitted traffic are counted, and pass. */
#define GATE_EXCESS_PASSES 4

/*
 * Why a frame was dropped; index of the reason counters. Of several slots with the frame's key the
 * one that came furthest gives the reason: UNKNOWN < IDENTIFIER < ... < DENIED is that order.
 */
enum gate_reason {
	GATE_R_PASSED = 0,
	GATE_R_UNKNOWN,	    /* no slot */
	GATE_R_IDENTIFIER,  /* priority, node, fragment or RTR differ from the grant */
	GATE_R_SOURCE,	    /* not from the granted station; egress: interface or user */
	GATE_R_FORMAT,	    /* classic/FD/XL not granted */
	GATE_R_LENGTH,	    /* longer than granted */
	GATE_R_DENIED,	    /* slot, verdict deny */
	GATE_R_ERROR_FRAME, /* error frame on its way out */
	GATE_R_MALFORMED,   /* not a CAN, CAN FD or CAN XL frame */
	GATE_R_CLOSED,	    /* gate closed: stopped, starting, or the daemon's heart-beat lapsed */
	/*
	 * Not a drop: echo of a frame that left here, let through at ingress; in audit mode also
	 * what ingress has refused and counted, let out.
	 */
	GATE_R_ECHO,
	GATE_R_ERROR_IN, /* not a drop: error frame let through at ingress */
	GATE_R_EXCESS,	 /* admitted, but more than was admitted: see gate_slot */
	GATE_R_FOREIGN,	 /* Ethernet, not a drop: no event traffic, left alone */
	GATE_R_FRAGMENT, /* part of a datagram or J1939 message whose first one was not admitted */
	GATE_R_OPAQUE,	 /* Ethernet: may carry an event, and its subject cannot be seen */
	GATE_REASONS = 16,
};

/*
 * One admitted or refused (subject, publisher) on one interface and direction. It says everything
 * that was granted and nothing more: a frame fits when (can_id & mask) == id, where both hold the
 * EFF and RTR flags of <linux/can.h> in place.
 * A slot of the profiles raw and canopen whose mask leaves part of the key open is a masked slot:
 * it has no bucket, and frames come to it whose own key has no slot. User space never changes a
 * live slot other than `verdict`, `next` and what is policed.
 *
 * Many verdicts change as one step, on all interfaces: the halves that the next generation will
 * read are written, then gate_control.generation, then the halves that no program reads any more. A
 * program that finds another generation at the end of a decision than at its beginning decides
 * again.
 *
 * Policing is the virtual scheduling form of the generic cell rate algorithm (ITU-T I.371): a frame
 * costs per_frame + bytes * per_byte of time, and is in turn when it comes no more than `tolerance`
 * before `due`. An empty frame costs as much as one of a byte.
 */
struct gate_slot {
	__u8 verdict[2]; /* enum gate_verdict, in even and in odd generations */
	__u16 max_len;	 /* payload bytes, of a message with GATE_TRANSPORT */
	__u32 id;
	__u32 mask;
	/* Egress: ifindex it must have entered by; 0: a local program; GATE_NO_SOURCE: the kernel
	 */
	__u32 source;
	union {
		__u32 origin; /* gate_has_origin(): see gate_origin() */
		__u32 uid;    /* otherwise: local sender's user, or GATE_ANY_UID */
	};
	__u16 next;   /* further slot of the same bucket; 0: none */
	__u8 formats; /* GATE_CLASSIC | GATE_FD | GATE_XL | GATE_TRANSPORT */
	/* FAMOUSO: see gate_binding; nothing passes. Set by the program, cleared by user space. */
	__u8 contradicted;
	__u64 subject;
	__u64 per_frame; /* ns; with per_byte 0: this slot is not policed */
	__u64 per_byte;	 /* 2^-8 ns */
	__u64 tolerance; /* ns */
	__u64 due;	 /* CLOCK_MONOTONIC ns of the next turn; written by the program */
};

/*
 * How the events of a slot come: the first cache line and the gaps are written by the gate, with
 * atomic operations where two CPUs may meet, the last line by the timer of the slot. What is
 * expected is written by user space. An event is one frame, or those that come within `together` of
 * its first one.
 */
struct gate_watch {
	__u64 period;	 /* ns; 0: not supervised */
	__u64 scale;	 /* gate_gap_scale(period) */
	__u64 together;	 /* ns; 0: each frame is an event */
	__u64 last;	 /* CLOCK_MONOTONIC ns of the latest event that passed, 0: none yet */
	__u64 last_gap;	 /* ns, as the others; 0: not two events yet */
	__u64 shortest;	 /* 0: not two events yet */
	__u64 longest;	 /* with what was missing in between */
	__u64 deviation; /* furthest that a gap was from the events that it should have been */
	__u64 gaps[GATE_GAPS];
	__u64 missing; /* events between those that came */
	__u64 silence; /* ns without an event that are too long; 0: no timer */
	__u64 since; /* CLOCK_MONOTONIC ns from which on silence counts, 0: from the next poll on */
	__u64 silent;	  /* it has lasted too long, and that was reported */
	__u64 from;	  /* when that silence began */
	__u64 recovering; /* since when events come again, 0: they do not */
	__u64 first;	  /* CLOCK_MONOTONIC ns of the first event */
	__u64 slot;	  /* Ethernet: whose events these are; on CAN each slot has its own */
};

/*
 * What audit mode lets through, of one slot. All CPUs add to it: enforcing pays nothing for it, and
 * what was dropped stays what gate_count says.
 */
struct gate_audit {
	__u64 would_drop;   /* frames */
	__u64 would_exceed; /* of them: admitted, but more than was admitted */
};

/*
 * One for each interface, one memory-mapped value. Written by user space, except for
 * `unknown_frames`, `last_reason`, the `due` of slots, `sessions`, what watches find and what
 * audit mode counts. A slot is a cache line.
 */
struct gate_table {
	__u32 layout_version;
	__u32 profile;	      /* enum gate_profile that the buckets were filled for */
	__u64 unknown_frames; /* frames without a slot: the order of gate_seen across CPUs */
	/*
	 * Of what leaves: 0 leaves skb->priority alone. Otherwise a frame goes into the first band
	 * whose limit is not below its gate_arbitration(), and into the last one if there is none.
	 */
	__u32 bands;
	__u32 band_limit[GATE_BANDS - 1];
	__u32 slots_end;	       /* all slots that were ever used are below this one */
	__u16 masked[GATE_DIRECTIONS]; /* first masked slot, 0 for none */
	__u64 sample_due;   /* as gate_slot.due, of the samples; written by the program */
	__u32 retired;	    /* the interface has left: its programs go with it */
	__u32 bindings_end; /* all bindings that were ever used are below this one */
	__u32 binding_news; /* how often something was found about one */
	__u32 epoch;	    /* of the daemon that holds the gate: see gate_control */
	__u64 reply_due;    /* as gate_slot.due, of reports of replies; written by the program */
	__u64 pad2;
	struct gate_slot slots[GATE_SLOTS];
	struct gate_watch watches[GATE_SLOTS];
	__u16 head[GATE_DIRECTIONS][GATE_BUCKETS]; /* bucket -> first slot, 0 for none */
	/* enum gate_reason of the latest drop, or of what would have been one; 0: none */
	__u8 last_reason[GATE_SLOTS];
	__u64 would_drop[GATE_DIRECTIONS][GATE_REASONS]; /* frames, in audit mode */
	struct gate_audit audit[GATE_SLOTS];
	struct gate_binding bindings[GATE_BINDINGS];
	struct gate_half halves[GATE_DIRECTIONS][GATE_ASKERS];
	struct gate_session sessions[GATE_DIRECTIONS][GATE_TP_SOURCES]; /* by source address */
};

struct gate_count {
	__u64 passed;
	__u64 dropped; /* really: see gate_audit */
	__u64 bytes;   /* payload bytes passed; a remote frame has none */
	/*
	 * More than admitted; of them dropped those that do not pass all the same. In audit mode
	 * only the latter are counted here.
	 */
	__u64 excess;
};

/* A frame without a slot; entry [hash(id)] is overwritten by the latest. */
struct gate_seen {
	__u64
	    sequence; /* value of unknown_frames when it was last seen; 0: empty or being written */
	__u64 count;  /* frames of this id since it took the entry */
	__u32 can_id;
	__u16 len;
	__u8 format; /* GATE_CLASSIC, GATE_FD or GATE_XL */
	__u8 direction;
};

/* One for each possible CPU, memory-mapped; written by that CPU, summed by user space. */
struct gate_cpu {
	struct gate_count slots[GATE_SLOTS];
	__u64 reasons[GATE_DIRECTIONS][GATE_REASONS]; /* frames; drops are real ones */
	struct gate_seen seen[GATE_SEEN];
};

enum gate_event_kind {
	GATE_E_MISSING = 1, /* nothing has come for longer than `silence` */
	GATE_E_RESTORED,    /* events come again */
	GATE_E_UNKNOWN,	    /* a frame without a slot: a gate_sample */
	GATE_E_BOUND, /* gate_table.binding_news has changed; it may change without a report */
};

/* What the kernel reports by the ring, one for the whole gateway, in the order of the reports. */
struct gate_event {
	__u32 kind; /* enum gate_event_kind */
	__u32 ifindex;
	__u64 subject;
	__u64 at;     /* CLOCK_MONOTONIC ns of the finding */
	__u64 silent; /* ns that nothing came: up to `at`, or until it came again */
	__u32 slot;
	__u32 never; /* nothing had come since the slot was granted */
};

/*
 * A frame without a slot that was not among the last seen ones before. Reported only while half of
 * the ring is free, so that no unadmitted sender takes the place of a gate_event.
 */
struct gate_sample {
	__u32 kind; /* GATE_E_UNKNOWN */
	__u32 ifindex;
	__u64 at;      /* CLOCK_MONOTONIC ns */
	__u64 frames;  /* without a slot on this interface, with this one */
	__u64 subject; /* Ethernet */
	__u32 can_id;  /* CAN */
	__u16 len;
	__u8 format; /* GATE_CLASSIC, GATE_FD or GATE_XL; 0: Ethernet */
	__u8 direction;
	__u64 station; /* Ethernet: as ether_seen, like `mac` */
	__u8 mac[6];
	__u8 audit; /* it was let through, and would have been dropped */
	__u8 pad;
};

/*
 * One for the whole gateway, pinned, memory-mapped. The gates are open only while `open` is set,
 * `lapsed` is not, and `deadline` is not over. Each heart-beat moves the deadline; a beat that
 * comes after it, or a kernel timer that finds `heartbeat` older than `grace_ns`, sets `lapsed`;
 * only the daemon clears it, after it has observed the interfaces again. A daemon that starts gives
 * each gate that it holds the next epoch, and then the word itself: from then on a gate that it
 * does not know is closed, wherever its device went. Layout version and `open` stand at the head in
 * all layouts: a daemon closes what one of another layout has left.
 */
struct gate_control {
	__u32 layout_version;
	__u32 open;
	__u32 mode; /* enum gate_mode */
	__u32 lapsed;
	__u64 deadline;	 /* jiffies; ~0: for ever, 0: no heart-beat yet */
	__u64 heartbeat; /* CLOCK_MONOTONIC ns of the daemon's last sign of life */
	__u32 token;	 /* random: see gate_ingress_token() */
	__u32 armed;	 /* the timer runs */
	__u32
	    generation; /* of all verdicts: its lowest bit chooses the half of gate_slot.verdict */
	__u32 epoch;	/* how often a daemon has taken over: gates of an earlier one are closed */
	__u64 grace_ns; /* ~0: for ever */
	__u64 grace_ticks; /* the same in jiffies, rounded up; ~0: for ever */
	__u64 check_ns;	   /* interval of the kernel timer */
	__u64 lapses;	   /* how often the gates were closed for silence */
};

#define GATE_CONTROL_NAME "mlcca_control" /* of its map, for programs that nothing else names */

/* One of the programs that read such a word: see roster.bpf.c. */
struct gate_program {
	__u32 id;
	char name[16];
};

/* What gate_beat is run for. */
enum gate_beat {
	GATE_BEAT = 0,	   /* the daemon lives */
	GATE_BEAT_CLEAR,   /* it has observed again: the lapse is over */
	GATE_BEAT_SHORTEN, /* the grace has changed: the deadline may come nearer, no more */
};

/*
 * The part of an identifier that is the key, 0 where the profile has no subject for it; frames of
 * other keys can share a bucket.
 */
static inline __u32 gate_key_mask(__u32 profile, __u32 can_id)
{
	if (profile == GATE_PROFILE_RAW)
		return CAN_EFF_FLAG | CAN_EFF_MASK;
	if (profile == GATE_PROFILE_CANOPEN)
		return can_id & CAN_EFF_FLAG ? 0 : CAN_EFF_FLAG | CAN_EFF_MASK;
	if (!(can_id & CAN_EFF_FLAG))
		return 0;
	if (profile == GATE_PROFILE_FAMOUSO)
		return CAN_EFF_FLAG | GATE_ETAG_MASK;
	if (profile == GATE_PROFILE_J1939)
		return CAN_EFF_FLAG |
		       ((can_id & GATE_J1939_PDU2) == GATE_J1939_PDU2 ? GATE_J1939_PDU2_KEY
								      : GATE_J1939_PDU1_KEY);
	if (profile == GATE_PROFILE_CYPHAL && !(can_id & GATE_CYPHAL_FOREIGN))
		return CAN_EFF_FLAG | GATE_CYPHAL_KEY;
	return 0;
}

/* Bucket of a frame or slot, or GATE_NO_BUCKET where the profile has no subject for it. */
static inline __u32 gate_bucket(__u32 profile, __u32 can_id)
{
	__u32 key_mask = gate_key_mask(profile, can_id);

	if (!key_mask)
		return GATE_NO_BUCKET;
	if (profile == GATE_PROFILE_FAMOUSO)
		return can_id & GATE_ETAG_MASK;
	if (profile == GATE_PROFILE_CYPHAL)
		return (can_id & GATE_CYPHAL_KEY) >> GATE_CYPHAL_SHIFT;
	if (!(can_id & CAN_EFF_FLAG))
		return can_id & CAN_SFF_MASK;
	/* Multiplication by 2^32 over the golden ratio spreads neighbours. */
	return GATE_STANDARD_BUCKETS +
	       (((can_id & key_mask & CAN_EFF_MASK) * 0x9e3779b1U) >> (32 - GATE_HASH_BITS));
}

/* The order of arbitration as one number: the smaller identifier wins. */
static inline __u32 gate_arbitration(__u32 can_id)
{
	if (!(can_id & CAN_EFF_FLAG))
		return (can_id & CAN_SFF_MASK) << 19;
	return (can_id & CAN_EFF_MASK) >> 18 << 19 | 1U << 18 | (can_id & 0x3ffffU);
}

/* Rounded up: a gap of just an eighth is in the bin that begins there. 0: not to be watched. */
static inline __u64 gate_gap_scale(__u64 period)
{
	if (!period || period > GATE_LONGEST_PERIOD)
		return 0;
	return ((__u64)GATE_GAPS_PERIOD << GATE_GAP_BITS) / period + 1;
}

/* An ingress slot gives its frames an origin; an egress slot demands one of what came in by an
 * interface. */
static inline int gate_has_origin(__u32 direction, __u32 source)
{
	return direction == GATE_INGRESS || (source && source != GATE_NO_SOURCE);
}

/*
 * As what a frame was admitted at ingress, in 31 bits: the subject and the publisher, by which
 * the slot distinguishes its frames: gate_publisher() on CAN, ether_station() on Ethernet. Two of
 * them are the same with a chance of 2^-31.
 */
static inline __u32 gate_origin(__u64 subject, __u64 publisher)
{
	return (__u32)((subject * 0x9e3779b97f4a7c15ULL + publisher * 0xd6e8feb86659fd93ULL) >> 33);
}

static inline __u64 gate_publisher(__u32 id, __u32 mask) { return (__u64)mask << 32 | id; }

/*
 * Marks that frames carry inside this kernel. The ingress gate of an interface marks what it has
 * passed: from where, and with the origin of its slot, so that egress admits neither a frame of a
 * third bus nor one that was admitted as another subject or as another publisher's, whatever was
 * done to its identifier or address on the way. The egress gate marks what it lets out to a device
 * that echoes. What only audit mode lets through is marked at ingress, so that egress does not
 * count it once more. The token's top bit is set, not all others are, the lowest left aside, and
 * neither an ifindex nor an origin has a top bit: no mark is 0, and an ingress mark is never one of
 * the others.
 */
static inline __u32 gate_ingress_token(__u32 token, __u32 ifindex, __u32 origin)
{
	return token ^ ifindex ^ origin;
}

static inline __u32 gate_echo_token(__u32 token) { return ~token; }

static inline __u32 gate_refused_token(__u32 token) { return ~token ^ 1; }

#ifdef __cplusplus
#define GATE_ASSERT static_assert
#else
#define GATE_ASSERT _Static_assert
#endif
GATE_ASSERT(sizeof(struct gate_slot) == 64, "gate_slot is pinned layout");
GATE_ASSERT(sizeof(struct gate_watch) == 256, "gate_watch is pinned layout");
GATE_ASSERT(sizeof(struct gate_audit) == 16, "gate_audit is pinned layout");
GATE_ASSERT(sizeof(struct gate_binding) == 40 && sizeof(struct gate_half) == 8,
	    "gate_binding.h is pinned layout");
GATE_ASSERT(sizeof(struct gate_session) == 16, "gate_transport.h is pinned layout");
GATE_ASSERT(sizeof(struct gate_table) == 128 + (64 + 256) * 4096 + 4 * 18432 + 4096 + 256 +
					     16 * 4096 + 40 * 4096 + 8 * 512 + 16 * 512,
	    "gate_table is pinned layout");
GATE_ASSERT(sizeof(struct gate_count) == 32, "gate_count is pinned layout");
GATE_ASSERT(sizeof(struct gate_seen) == 24, "gate_seen is pinned layout");
GATE_ASSERT(sizeof(struct gate_cpu) == 32 * 4096 + 8 * 32 + 24 * 64, "gate_cpu is pinned layout");
GATE_ASSERT(sizeof(struct gate_event) == 40, "gate_event is pinned layout");
GATE_ASSERT(sizeof(struct gate_sample) == 56, "gate_sample is pinned layout");
GATE_ASSERT(sizeof(struct gate_control) == 80, "gate_control is pinned layout");

#endif
