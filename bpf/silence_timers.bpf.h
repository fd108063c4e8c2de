/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Silence timers: kernel timers that notice when a watched slot of one interface had no event for
 * too long. A timer expires when the oldest of the latest events of its slots would be too old. It
 * then checks whether later events have arrived, and is set again according to those: so it follows
 * the channels and does not drift. The kernel may refuse memory for a timer at any time (6.18 often
 * does), so a few timers serve all slots, and they are made together with the gate. A value with a
 * timer cannot be memory-mapped, so they have a map of their own.
 *
 * A file that includes this one defines the largest number of watches (WATCHES) and these
 * functions: the upper bound of the watches in use, the n-th watch, and the subject, number and
 * verdict of its slot.
 */
#ifndef MLCCA_SILENCE_TIMERS_BPF_H
#define MLCCA_SILENCE_TIMERS_BPF_H

static __u32 watches_end(void);
static struct gate_watch *watch_of(__u32 at);
static __u64 subject_of(__u32 at, const struct gate_watch *w);
static __u32 slot_number(__u32 at, const struct gate_watch *w);
static bool passes(__u32 at, const struct gate_watch *w);

#define SHORTEST_WAIT 100000ULL	   /* ns, so that no Period can keep a CPU busy */
#define AT_LEISURE    100000000ULL /* ns, for cases in which no one waits for the result */

const volatile __u32 ifindex = 0; /* set before loading */

#include "bpf/closed.bpf.h"

struct {
	__uint(type, BPF_MAP_TYPE_RINGBUF);
	__uint(max_entries, GATE_EVENTS_SIZE);
} events SEC(".maps");

struct silence_timer {
	struct bpf_timer timer;
	__u64 armed; /* number of times that one of its watches was armed */
};

struct {
	__uint(type, BPF_MAP_TYPE_ARRAY);
	__uint(max_entries, GATE_SILENCE_TIMERS);
	__type(key, __u32);
	__type(value, struct silence_timer);
} silence_timers SEC(".maps");

static bool passes_now(const __u8 *verdict)
{
	return READ_ONCE(verdict[READ_ONCE(control.generation) & 1]) == GATE_PASS;
}

/* Returns false if the ring buffer is full; then it is reported at the next tick. */
static bool report(__u32 at, const struct gate_watch *w, __u32 kind, __u64 now, __u64 silent)
{
	struct gate_event event = {
	    .kind = kind,
	    .ifindex = ifindex,
	    .subject = subject_of(at, w),
	    .at = now,
	    .silent = silent,
	    .slot = slot_number(at, w),
	    .never = !READ_ONCE(w->last),
	};

	return !bpf_ringbuf_output(&events, &event, sizeof(event), 0);
}

/* For a silent slot: reports its recovery when events have arrived for a while without a gap. */
static void await_recovery(__u32 at, struct gate_watch *w, bool quiet, __u64 now)
{
	if (quiet)
		w->recovering = 0;
	else if (!w->recovering)
		w->recovering = now;
	else if (now - w->recovering >= GATE_RECOVERY_HOLD &&
		 report(at, w, GATE_E_RESTORED, now, w->recovering - w->from))
		w->silent = 0;
}

/*
 * Polls a slot. Returns the time in ns until the next poll; 0: none. It is not static, so that the
 * verifier checks it once.
 */
__noinline __u64 poll_watch(__u32 at)
{
	struct gate_watch *w = watch_of(at);
	__u64 silence, period, last, now, since;

	if (!w)
		return 0;
	silence = READ_ONCE(w->silence);
	period = READ_ONCE(w->period);
	/*
	 * The event is read before the clock, so that an event in between does not count as a long
	 * silence.
	 */
	last = READ_ONCE(w->last);
	now = bpf_ktime_get_ns();
	if (!silence || !passes(at, w))
		return 0;
	if (closed(READ_ONCE(table.epoch))) {
		/* No event can pass, so silence begins when the gates open. */
		w->since = 0;
		w->silent = 0;
		return silence < AT_LEISURE ? silence : AT_LEISURE;
	}
	if (!w->since)
		w->since = now;
	since = last > w->since ? last : w->since;
	if (w->silent) {
		await_recovery(at, w, now - since >= silence, now);
		return period > AT_LEISURE ? period : AT_LEISURE;
	}
	if (now < since + silence)
		return since + silence - now;
	if (report(at, w, GATE_E_MISSING, now, now - since)) {
		w->silent = 1;
		w->from = since;
		w->recovering = 0;
	}
	return period;
}

static int tick(void *map, __u32 *key, struct silence_timer *own)
{
	__u64 armed = READ_ONCE(own->armed), soonest = 0;
	__u32 end = watches_end(), at = *key, i;

	for (i = 0; i < WATCHES / GATE_SILENCE_TIMERS && at < end; i++, at += GATE_SILENCE_TIMERS) {
		__u64 wait = poll_watch(at);

		if (wait && (!soonest || wait < soonest))
			soonest = wait;
	}
	if (soonest)
		bpf_timer_start(&own->timer, soonest < SHORTEST_WAIT ? SHORTEST_WAIT : soonest, 0);
	/* A watch was armed in between, and its time was just overwritten. */
	if (READ_ONCE(own->armed) != armed)
		bpf_timer_start(&own->timer, SHORTEST_WAIT, 0);
	return 0;
}

/*
 * Makes the timers. After a restart of the daemon they exist; then only their callback is replaced.
 * Like watch_arm() it is run by BPF_PROG_TEST_RUN, because only programs can use timers. Returns 0
 * or a negative errno.
 */
SEC("tc")
int watch_make(struct __sk_buff *skb)
{
	__u32 key;

	for (key = 0; key < GATE_SILENCE_TIMERS; key++) {
		__u32 at = key;
		struct silence_timer *own = bpf_map_lookup_elem(&silence_timers, &at);
		long err;

		if (!own)
			return -ENOENT;
		err = bpf_timer_init(&own->timer, &silence_timers, CLOCK_MONOTONIC);
		if (err && err != -EBUSY)
			return err;
		err = bpf_timer_set_callback(&own->timer, tick);
		if (err)
			return err;
	}
	return 0;
}

/* Polls the watch `skb->mark` from now on. A silence that was reported is reported once more. */
SEC("tc")
int watch_arm(struct __sk_buff *skb)
{
	__u32 at = skb->mark, key = at % GATE_SILENCE_TIMERS;
	struct silence_timer *own = bpf_map_lookup_elem(&silence_timers, &key);
	struct gate_watch *w = watch_of(at);

	if (!own || !w)
		return -ENOENT;
	w->silent = 0;
	__sync_fetch_and_add(&own->armed, 1);
	return bpf_timer_start(&own->timer, SHORTEST_WAIT, 0);
}

#endif
