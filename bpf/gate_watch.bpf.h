/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Watches the arrival of a slot's events. The atomic exchange of `last` gives each gap to one
 * frame, whatever other CPUs do, so that every gap is counted once. No timer is touched here: that
 * of the slot (watch.bpf.c) reads `last` when it expires.
 */
#ifndef MLCCA_GATE_WATCH_BPF_H
#define MLCCA_GATE_WATCH_BPF_H

/* A try fails only if another CPU has stored a more extreme value, so a few tries suffice. */
#define EXTREME_TRIES 4

static __always_inline void raise(__u64 *most, __u64 value)
{
	__u32 i;

	for (i = 0; i < EXTREME_TRIES; i++) {
		__u64 seen = READ_ONCE(*most);

		if (value <= seen || __sync_val_compare_and_swap(most, seen, value) == seen)
			return;
	}
}

static __always_inline void lower(__u64 *least, __u64 value)
{
	__u32 i;

	for (i = 0; i < EXTREME_TRIES; i++) {
		__u64 seen = READ_ONCE(*least);

		if ((seen && value >= seen) ||
		    __sync_val_compare_and_swap(least, seen, value) == seen)
			return;
	}
}

static __always_inline bool is_silence(const struct gate_watch *w, __u64 period, __u64 gap)
{
	__u64 silence = READ_ONCE(w->silence);

	if (!silence)
		silence = GATE_SILENT_PERIODS * period;
	return gap >= silence && gap >= GATE_RECOVERY_HOLD;
}

/*
 * Restarts the statistics with the event at `now` as the first one. Another CPU may still add a
 * gap.
 */
static void restart_statistics(struct gate_watch *w, __u64 now)
{
	__u32 i;

	for (i = 0; i < GATE_GAPS; i++)
		WRITE_ONCE(w->gaps[i], 0);
	WRITE_ONCE(w->first, now);
	WRITE_ONCE(w->missing, 0);
	WRITE_ONCE(w->last_gap, 0);
	WRITE_ONCE(w->shortest, 0);
	WRITE_ONCE(w->longest, 0);
	WRITE_ONCE(w->deviation, 0);
}

static __always_inline void watch(struct gate_watch *w, __u64 period, __u64 now)
{
	__u64 together = READ_ONCE(w->together);
	__u64 last, gap, expected = period;
	__u32 bin = GATE_GAPS - 1;

	if (together && now - READ_ONCE(w->last) < together)
		return;
	last = __sync_lock_test_and_set(&w->last, now);
	if (!last) {
		WRITE_ONCE(w->first, now);
		return;
	}
	/*
	 * The clock is read before the exchange, so of two frames the later one may have been
	 * first.
	 */
	gap = now > last ? now - last : 1;
	if (is_silence(w, period, gap)) {
		restart_statistics(w, now);
		return;
	}
	if (gap < 2 * period)
		bin = gap * READ_ONCE(w->scale) >> GATE_GAP_BITS;
	__sync_fetch_and_add(&w->gaps[bin & (GATE_GAPS - 1)], 1);
	if (bin >= GATE_GAPS_MISSING) {
		__u64 events = (gap + period / 2) / period;

		__sync_fetch_and_add(&w->missing, events - 1);
		expected = events * period;
	}
	WRITE_ONCE(w->last_gap, gap);
	lower(&w->shortest, gap);
	raise(&w->longest, gap);
	raise(&w->deviation, gap > expected ? gap - expected : expected - gap);
}

#endif
