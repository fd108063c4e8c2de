/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * The decision, as far as gates of CAN and of Ethernet decide alike: the walk over the slots of one
 * subject, and that all of it is read by the verdicts of one generation. A kind of gate defines
 * before it
 *   ASKED       the struct that is decided about, with `generation` and `read`
 *   CONTEXT     the parameter in front that fit_apart() needs, with its comma, or nothing
 *   OF_CONTEXT  the argument for it
 * and behind it the functions that are declared here.
 */
#ifndef MLCCA_DECIDE_BPF_H
#define MLCCA_DECIDE_BPF_H

struct decision {
	__u32 slot;
	__u32 reason; /* enum gate_reason */
};

/* A decision in one word, as functions that the verifier checks once by themselves return it. */
static __always_inline __u64 packed(__u32 reason, __u32 slot) { return (__u64)reason << 32 | slot; }

static __always_inline struct decision unpacked(__u64 found)
{
	return (struct decision){.slot = found, .reason = found >> 32};
}

/* Whether the slot admits it; GATE_R_UNKNOWN: the slot is for another subject. */
__noinline __u32 fit_apart(CONTEXT __u32 at, struct ASKED *asked, __u32 direction);
/* The slot behind this one; 0: it is the last. */
static __always_inline __u32 next_of(__u32 at);
/* As walk(), from the first slot that the subject may have. Leaves in `read` what it read. */
static __always_inline __u64 walk_from_head(CONTEXT struct ASKED *asked, __u32 direction);

/* The verdict of a slot, by the generation that is decided by. */
static __always_inline __u32 reason_of_verdict(const __u8 *verdict, struct ASKED *asked)
{
	__u32 now = READ_ONCE(verdict[asked->generation & 1]);

	asked->read += now;
	return now == GATE_PASS ? GATE_R_PASSED : GATE_R_DENIED;
}

/*
 * Passes when any slot of the subject admits it. Otherwise gives the slot that came furthest, of
 * equals the first; the direction's own slot where the subject has none.
 *
 * Not static: the verifier checks it once by itself, and takes its result for any number. Static
 * functions would multiply with every way that leads to and from them.
 */
__noinline __u64 walk(CONTEXT __u32 at, struct ASKED *asked, __u32 direction)
{
	__u32 slot = direction, best = GATE_R_UNKNOWN;
	__u64 i; /* alone in its word of the stack, or the verifier loses count */

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

/* By the verdicts of one generation, after another one has begun during the first try. */
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

/* What was found, if all of it was read by one generation; else the same decided again. */
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
