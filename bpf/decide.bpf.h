/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * The part of the decision that gates of CAN and of Ethernet have in common: the walk over the
 * slots of one subject, and the check that all of it was read in one generation of verdicts. A kind
 * of gate defines before it is included:
 *   ASKED       the struct that is decided about, with the members `generation` and `read`
 *   CONTEXT     the parameter that fit_apart() needs in front, with its comma, or nothing
 *   OF_CONTEXT  the argument for it
 * and after it the functions that are declared here.
 */
#ifndef MLCCA_DECIDE_BPF_H
#define MLCCA_DECIDE_BPF_H

struct decision {
	__u32 slot;
	__u32 reason; /* enum gate_reason */
};

/* A decision in one word, because functions that the verifier checks separately return a scalar. */
static __always_inline __u64 packed(__u32 reason, __u32 slot) { return (__u64)reason << 32 | slot; }

static __always_inline struct decision unpacked(__u64 found)
{
	return (struct decision){.slot = found, .reason = found >> 32};
}

/*
 * Whether the slot admits `asked`, as enum gate_reason; GATE_R_UNKNOWN: it is for another subject.
 */
__noinline __u32 fit_apart(CONTEXT __u32 at, struct ASKED *asked, __u32 direction);
/* The slot after this one in the chain; 0: it is the last one. */
static __always_inline __u32 next_of(__u32 at);
/* Like walk(), from the first slot that the subject may have. Adds what it reads to `read`. */
static __always_inline __u64 walk_from_head(CONTEXT struct ASKED *asked, __u32 direction);

/* The verdict of a slot, as a reason, in the generation that is used for the decision. */
static __always_inline __u32 reason_of_verdict(const __u8 *verdict, struct ASKED *asked)
{
	__u32 now = READ_ONCE(verdict[asked->generation & 1]);

	asked->read += now;
	return now == GATE_PASS ? GATE_R_PASSED : GATE_R_DENIED;
}

/*
 * Passes if any slot of the subject admits it. Otherwise returns the reason of the slot that came
 * furthest, of equals the first; or the direction's own slot if the subject has none.
 *
 * It is not static, so that the verifier checks it once and takes any number for its result. For a
 * static function it would check every path that leads to and from it.
 */
__noinline __u64 walk(CONTEXT __u32 at, struct ASKED *asked, __u32 direction)
{
	__u32 slot = direction, best = GATE_R_UNKNOWN;
	__u64 i; /* alone in its stack word, or the verifier loses its value */

	if (!asked)
		return packed(GATE_R_UNKNOWN, direction);
	for (i = 0; i < GATE_WALK && at; i++) {
		__u32 reason = fit_apart(OF_CONTEXT at, asked, direction);

		if (reason == GATE_R_PASSED)
			return packed(GATE_R_PASSED, at);
		if (reason > best) {
			best = reason;
			slot = at;
		}
		at = next_of(at);
		asked->read += at;
	}
	return packed(best, slot);
}

/* Decides again in one generation, because another one began during the first try. */
__noinline __u64 decide_again(CONTEXT const struct ASKED *asked, __u32 direction)
{
	struct ASKED copy;
	__u64 found;
	__u32 i;

	direction &= GATE_DIRECTIONS - 1;
	if (!asked)
		return packed(GATE_R_UNKNOWN, direction);
	copy = *asked;
	for (i = 0; i < GATE_TRIES; i++) {
		copy.generation = READ_ONCE(control.generation);
		copy.read = 0;
		found = walk_from_head(OF_CONTEXT & copy, direction);
		if (!moved_on(copy.generation, copy.read))
			return found;
	}
	return packed(GATE_R_DENIED, direction);
}

/* The result that was found if all of it was read in one generation; otherwise decides again. */
static __always_inline struct decision settled(CONTEXT const struct ASKED *asked, __u32 direction,
					       __u64 found)
{
	struct ASKED copy;

	if (!moved_on(asked->generation, asked->read))
		return unpacked(found);
	copy = *asked;
	return unpacked(decide_again(OF_CONTEXT & copy, direction));
}

#endif
