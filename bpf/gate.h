/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * The definitions that the gate programs and user space share. Both sides assert every size. A
 * change of any layout here needs a new GATE_LAYOUT_VERSION, which is part of the pin path.
 */
#ifndef MLCCA_GATE_H
#define MLCCA_GATE_H

#include <linux/can.h>
#include <linux/types.h>

#include "bpf/gate_binding.h"
#include "bpf/gate_seen.h"
#include "bpf/gate_transport.h"
#include "core/profiles/layout.h"

#define GATE_LAYOUT_VERSION 10

/* Priority and handle of our tc filters. No filter with others is ever replaced. */
#define GATE_TC_PRIORITY 1
#define GATE_TC_HANDLE	 0x4d4c4343 /* "MLCC" */

#define GATE_INGRESS	0
#define GATE_EGRESS	1
#define GATE_DIRECTIONS 2

/* Slots of one interface for both directions. Slots 0 and 1 count frames without a slot. */
#define GATE_SLOTS	4096
#define GATE_FIRST_SLOT 2

/* Slots of one key (publishers of one subject on a CAN interface): half of GATE_WALK. */
#define GATE_CHAIN 16
/* Decisions on one frame that changes of generation may invalidate; then the frame is denied. */
#define GATE_TRIES 32
/*
 * Slots of one bucket that the program walks, since several 29-bit identifiers may have the same
 * hash. It is also the largest number of masked slots of a direction.
 */
#define GATE_WALK 32

/*
 * Histogram of the gaps between events of a slot, in eighths of its period: [n] counts gaps of n to
 * n + 1 eighths, the last one all longer ones. From 12 on (1.5 periods) an event is missing.
 */
#define GATE_GAPS	  16
#define GATE_GAPS_PERIOD  8
#define GATE_GAPS_MISSING 12
#define GATE_GAP_BITS	  56 /* fractional bits of gap * scale */
/*
 * A gap of at least `silence` of its watch (or so many periods, if that is 0) and of at least
 * GATE_RECOVERY_HOLD is a silence: the statistics start over with the event that ends it.
 */
#define GATE_SILENT_PERIODS 16
#define GATE_LONGEST_PERIOD (1ULL << 50) /* ns, 13 days; longer periods are not watched */

#define GATE_SILENCE_TIMERS 16 /* timers of one interface; each supervises every 16th slot */
#define GATE_RECOVERY_HOLD                                                                         \
	1000000000ULL /* ns for which events must arrive again before it is reported */
#define GATE_EVENTS_SIZE (256 * 1024) /* bytes of the ring buffer of gate_event and gate_sample */

/* Samples of frames without a slot, for each interface: so many at once, then one in that time. */
#define GATE_SAMPLES   16
#define GATE_SAMPLE_NS 1000000000ULL

/* Bands of the prio queueing discipline after a gate; the first one is served first. */
#define GATE_BANDS 16

#define GATE_ANY_UID 0xffffffffU
/*
 * Source of a frame that has entered by no interface and belongs to no socket: the kernel made it
 * (the transport protocol of can-j1939).
 */
#define GATE_NO_SOURCE 0xffffffffU

enum gate_verdict {
	GATE_DENY = 0,
	GATE_PASS = 1,
};

enum gate_mode {
	GATE_ENFORCE = 0,
	GATE_AUDIT = 1, /* drop nothing, and count separately what would be dropped */
};

/* Bit set of the frame formats of a slot. */
#define GATE_CLASSIC 1
#define GATE_FD	     2
#define GATE_XL	     8 /* identifier: the 11-bit priority */
/*
 * J1939: also messages of 9 to max_len bytes by the transport protocol. A single frame has no more
 * bytes than its own format allows.
 */
#define GATE_TRANSPORT 16
/* In the same bits: frames in excess of the admitted traffic are counted and passed. */
#define GATE_EXCESS_PASSES 4

/*
 * Why a frame passed or was dropped; the index of the reason counters: GATE_R_UNKNOWN is the number
 * of frames without a slot. The list has the meaning of each.
 */
enum gate_reason {
#define FRAME_REASON(number, word, WORD, name, kind, text) GATE_R_##WORD = number,
#include "core/gates/frame_reasons.inc"
#undef FRAME_REASON
	GATE_REASONS = 16,
};

/*
 * One admitted or refused (subject, publisher) on one interface and direction. It describes exactly
 * what was granted: a frame fits if (can_id & mask) == id, where both include the EFF and RTR flags
 * of <linux/can.h>.
 * A slot of the profiles raw and canopen whose mask leaves a part of the key open is a masked slot:
 * it has no bucket, and serves frames whose own key has no slot. User space changes only `verdict`,
 * `next` and the policing of a live slot.
 *
 * Many verdicts change in one step on all interfaces: user space writes the halves that the next
 * generation reads, then gate_control.generation, then the other halves. A program that finds
 * another generation at the end of a decision than at its beginning decides again.
 *
 * Policing is the virtual scheduling form of the generic cell rate algorithm (ITU-T I.371): a frame
 * costs per_frame + bytes * per_byte of time, and conforms if it arrives no more than `tolerance`
 * before `due`. An empty frame costs as much as one of a byte.
 */
struct gate_slot {
	__u8 verdict[2]; /* enum gate_verdict, for even and odd generations */
	__u16 max_len;	 /* payload bytes; with GATE_TRANSPORT of a message */
	__u32 id;
	__u32 mask;
	/* Egress: ifindex that it entered by; 0: a local program; GATE_NO_SOURCE: the kernel */
	__u32 source;
	union {
		__u32 origin; /* if gate_has_origin(): see gate_origin() */
		__u32 uid;    /* otherwise: user of the local sender, or GATE_ANY_UID */
	};
	__u16 next;   /* next slot of the same bucket; 0: none */
	__u8 formats; /* GATE_CLASSIC | GATE_FD | GATE_XL | GATE_TRANSPORT */
	/* FAMOUSO: see gate_binding; nothing passes. Set by the program, cleared by user space. */
	__u8 contradicted;
	__u64 subject;
	__u64 per_frame; /* ns; 0 together with per_byte 0: not policed */
	__u64 per_byte;	 /* 2^-8 ns */
	__u64 tolerance; /* ns */
	__u64 due; /* CLOCK_MONOTONIC ns of the next conforming frame; written by the program */
};

/*
 * The arrival of the events of a slot. The gate writes the first cache line and the gaps, with
 * atomic operations where two CPUs may meet; the timer of the slot writes the last line; user space
 * writes what is expected. An event is one frame, or the frames within `together` of its first one.
 */
struct gate_watch {
	__u64 period;	 /* ns; 0: not supervised */
	__u64 scale;	 /* gate_gap_scale(period) */
	__u64 together;	 /* ns; 0: each frame is an event */
	__u64 last;	 /* CLOCK_MONOTONIC ns of the latest event that passed; 0: none yet */
	__u64 last_gap;	 /* ns, like the others; 0: fewer than two events yet */
	__u64 shortest;	 /* 0: fewer than two events yet */
	__u64 longest;	 /* includes missing events in between */
	__u64 deviation; /* largest difference of a gap from a multiple of the period */
	__u64 gaps[GATE_GAPS];
	__u64 missing;	  /* events missing between those that arrived */
	__u64 silence;	  /* ns without an event that are too long; 0: no timer */
	__u64 since;	  /* CLOCK_MONOTONIC ns since when silence counts; 0: since the next poll */
	__u64 silent;	  /* the silence was too long, and was reported */
	__u64 from;	  /* when that silence began */
	__u64 recovering; /* since when events arrive again; 0: they do not */
	__u64 first;	  /* CLOCK_MONOTONIC ns of the first event */
	__u64 slot;	  /* Ethernet: slot of the events; on CAN each slot has its own watch */
};

/*
 * What audit mode passed, for one slot. All CPUs add to it, since enforcing does not use it; what
 * was really dropped is in gate_count.
 */
struct gate_audit {
	__u64 would_drop;   /* frames */
	__u64 would_exceed; /* of these: admitted, but in excess */
};

/*
 * The table of one interface, one memory-mapped value. User space writes it, except for
 * `unknown_frames`, `refused_senders`, `last_reason`, the `due` of slots, `sessions`, the findings
 * of watches and the counters of audit mode. A slot is a cache line.
 */
struct gate_table {
	__u32 layout_version;
	__u32 profile;	      /* enum gate_profile for which the buckets were filled */
	__u64 unknown_frames; /* frames without a slot; orders gate_seen across CPUs */
	/*
	 * Egress: 0 leaves skb->priority unchanged. Otherwise a frame is put into the first band
	 * whose limit is not below its gate_arbitration(), or into the last one without such.
	 */
	__u32 bands;
	__u32 band_limit[GATE_BANDS - 1];
	__u32 slots_end;	       /* exclusive upper bound of all slots that were ever used */
	__u16 masked[GATE_DIRECTIONS]; /* first masked slot, 0 for none */
	__u64 sample_due;	       /* like gate_slot.due, for samples; written by the program */
	__u32 retired;	    /* the interface was removed from the gateway: its programs pass all */
	__u32 bindings_end; /* exclusive upper bound of all bindings that were ever used */
	__u32 binding_news; /* number of findings about bindings */
	__u32 epoch;	    /* of the daemon that holds the gate, see gate_control */
	__u64 reply_due;    /* like gate_slot.due, for reports of replies; written by the program */
	__u64 refused_senders; /* frames noted in gate_sender; orders them across CPUs */
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
	__u64 dropped; /* really dropped; see gate_audit */
	__u64 bytes;   /* payload bytes passed; remote frames have none */
	/*
	 * Frames in excess: those that were dropped, and those that passed by GATE_EXCESS_PASSES.
	 * In audit mode only the latter are counted here.
	 */
	__u64 excess;
};

/* The counters of one CPU, memory-mapped; written by that CPU, summed by user space. */
struct gate_cpu {
	struct gate_count slots[GATE_SLOTS];
	__u64 reasons[GATE_DIRECTIONS][GATE_REASONS]; /* frames; drops are real ones */
	struct gate_seen seen[GATE_SEEN];
	struct gate_sender senders[GATE_SENDERS];
};

enum gate_event_kind {
	GATE_E_MISSING = 1, /* nothing has arrived for longer than `silence` */
	GATE_E_RESTORED,    /* events arrive again */
	GATE_E_UNKNOWN,	    /* a frame without a slot: a gate_sample */
	GATE_E_BOUND, /* gate_table.binding_news has changed; it may also change without a report */
};

/* A report of the kernel by the ring buffer, which all gates share, in the order of the reports. */
struct gate_event {
	__u32 kind; /* enum gate_event_kind */
	__u32 ifindex;
	__u64 subject;
	__u64 at;     /* CLOCK_MONOTONIC ns of the finding */
	__u64 silent; /* ns without an event: up to `at`, or until events arrived again */
	__u32 slot;
	__u32 never; /* 1: nothing had arrived since the slot was granted */
};

/*
 * A frame without a slot that was not among the latest ones. It is reported only while half of the
 * ring buffer is free, so that unadmitted senders cannot displace a gate_event.
 */
struct gate_sample {
	__u32 kind; /* GATE_E_UNKNOWN */
	__u32 ifindex;
	__u64 at;      /* CLOCK_MONOTONIC ns */
	__u64 frames;  /* frames without a slot on this interface, including this one */
	__u64 subject; /* Ethernet */
	__u32 can_id;  /* CAN */
	__u16 len;
	__u8 format; /* GATE_CLASSIC, GATE_FD or GATE_XL; 0: Ethernet */
	__u8 direction;
	__u64 station; /* Ethernet: as in ether_seen, like `mac` */
	__u8 mac[6];
	__u8 audit; /* it was passed by audit mode, and would have been dropped */
	__u8 pad;
};

/*
 * The control word of the gateway, pinned and memory-mapped. The gates are open only while `open`
 * is set, `lapsed` is not, and `deadline` has not passed. Each heart-beat moves the deadline. A
 * beat after the deadline, or a kernel timer that finds `heartbeat` older than `grace_ns`, sets
 * `lapsed`; only the daemon clears it, after it has observed the interfaces again. A daemon that
 * starts gives the next epoch to each gate that it holds, and then to the control word: from then
 * on a gate that it does not know is closed, wherever its device went. Layout version and `open`
 * come first in all layouts, so that a daemon can close what one of another layout has left.
 */
struct gate_control {
	__u32 layout_version;
	__u32 open;
	__u32 mode; /* enum gate_mode */
	__u32 lapsed;
	__u64 deadline;	 /* jiffies; ~0: without limit; 0: no heart-beat yet */
	__u64 heartbeat; /* CLOCK_MONOTONIC ns of the daemon's latest heart-beat */
	__u32 token;	 /* random, see gate_ingress_token() */
	__u32 armed;	 /* the timer runs */
	__u32
	    generation; /* of all verdicts; its lowest bit selects the half of gate_slot.verdict */
	__u32 epoch;	/* number of daemon starts; gates of an earlier epoch are closed */
	__u64 grace_ns; /* ~0: without limit */
	__u64 grace_ticks; /* the same in jiffies, rounded up; ~0: without limit */
	__u64 check_ns;	   /* interval of the kernel timer */
	__u64 lapses;	   /* how often the gates were closed because the heart-beat was overdue */
};

#define GATE_CONTROL_NAME "mlcca_control" /* name of its map, by which roster.bpf.c finds ours */

/* A program that reads such a control word: see roster.bpf.c. */
struct gate_program {
	__u32 id;
	char name[16];
};

/* What a run of gate_beat is for. */
enum gate_beat {
	GATE_BEAT = 0,	   /* the daemon lives */
	GATE_BEAT_CLEAR,   /* the daemon has observed the interfaces again: the lapse is over */
	GATE_BEAT_SHORTEN, /* the grace period has changed: the deadline may only come nearer */
};

/* The order of arbitration as one number: the smaller one wins. */
static inline __u32 gate_arbitration(__u32 can_id)
{
	if (!(can_id & CAN_EFF_FLAG))
		return (can_id & CAN_SFF_MASK) << 19;
	return (can_id & CAN_EFF_MASK) >> 18 << 19 | 1U << 18 | (can_id & 0x3ffffU);
}

/*
 * The scale of a gap histogram, rounded up, so that a gap of exactly n eighths is in bin n. 0: not
 * watched.
 */
static inline __u64 gate_gap_scale(__u64 period)
{
	if (!period || period > GATE_LONGEST_PERIOD)
		return 0;
	return ((__u64)GATE_GAPS_PERIOD << GATE_GAP_BITS) / period + 1;
}

/*
 * Ingress slots give their frames an origin; egress slots require it of what entered by an
 * interface.
 */
static inline int gate_has_origin(__u32 direction, __u32 source)
{
	return direction == GATE_INGRESS || (source && source != GATE_NO_SOURCE);
}

/*
 * The origin of a frame, in 31 bits: the subject and the publisher as which it was admitted at
 * ingress. The publisher is gate_publisher() on CAN and ether_station() on Ethernet. Two origins
 * are equal with a probability of 2^-31.
 */
static inline __u32 gate_origin(__u64 subject, __u64 publisher)
{
	return (__u32)((subject * 0x9e3779b97f4a7c15ULL + publisher * 0xd6e8feb86659fd93ULL) >> 33);
}

static inline __u64 gate_publisher(__u32 id, __u32 mask) { return (__u64)mask << 32 | id; }

/*
 * Marks that frames carry inside this kernel. The ingress gate marks what it passes with its
 * interface and the origin of its slot, so that egress admits neither a frame of a third bus nor
 * one that was admitted as another subject or publisher, whatever was done to its identifier or
 * address on the way. The egress gate marks what it passes to a device that echoes. What only audit
 * mode passes is marked at ingress, so that egress does not count it again. The token's top bit is
 * set, its other bits (apart from the lowest) are not all set, and neither an ifindex nor an origin
 * has a top bit: so no mark is 0, and an ingress mark never equals one of the others.
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
GATE_ASSERT(sizeof(struct gate_sender) == 40, "gate_sender is pinned layout");
GATE_ASSERT(sizeof(struct gate_cpu) == 32 * 4096 + 8 * 32 + 24 * 64 + 40 * 64,
	    "gate_cpu is pinned layout");
GATE_ASSERT(sizeof(struct gate_event) == 40, "gate_event is pinned layout");
GATE_ASSERT(sizeof(struct gate_sample) == 56, "gate_sample is pinned layout");
GATE_ASSERT(sizeof(struct gate_control) == 80, "gate_control is pinned layout");

#endif
