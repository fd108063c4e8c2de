// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/*
 * The dead-man: closes all gates when the daemon's heart-beat stops. Each beat moves a deadline in
 * jiffies, which the gates themselves compare with the clock (closed.bpf.h). User space cannot read
 * jiffies, so a beat is a run of gate_beat. A kernel timer is the second line of defence: it counts
 * the lapse when no heart-beat comes. A value with a timer cannot be memory-mapped, so it has a map
 * of its own.
 */
#include <stdbool.h>
#include <linux/bpf.h>
#include <linux/pkt_cls.h>
#include <linux/time.h> /* CLOCK_MONOTONIC */
#include <bpf/bpf_helpers.h>

#include "bpf/gate.h"
#include "bpf/until.h"
#include "bpf/once.bpf.h"
#include "bpf/closed.bpf.h"

#define FOR_EVER       (~0ULL)
#define SHORTEST_CHECK 1000000ULL /* ns, so that a control word of 0 does not keep a CPU busy */

struct deadman {
	struct bpf_timer timer;
};

struct {
	__uint(type, BPF_MAP_TYPE_ARRAY);
	__uint(max_entries, 1);
	__type(key, __u32);
	__type(value, struct deadman);
} deadman SEC(".maps");

struct {
	__uint(type, BPF_MAP_TYPE_ARRAY);
	__uint(max_entries, 1);
	__type(key, __u32);
	__type(value, struct gate_until);
} until SEC(".maps");

static __u64 next_check(void)
{
	__u64 check = READ_ONCE(control.check_ns);

	return check < SHORTEST_CHECK ? SHORTEST_CHECK : check;
}

/* Timer and beat may notice the same silence, which counts as one lapse. */
static __always_inline void lapse(void)
{
	if (!__sync_lock_test_and_set(&control.lapsed, 1))
		__sync_fetch_and_add(&control.lapses, 1);
}

static int check_heartbeat(void *map, __u32 *key, struct deadman *d)
{
	__u64 grace = READ_ONCE(control.grace_ns);
	/*
	 * The heart-beat is read before the clock, so that a beat in between does not count as a
	 * long silence.
	 */
	__u64 heartbeat = READ_ONCE(control.heartbeat);
	__u64 now = bpf_ktime_get_ns();

	if (grace != FOR_EVER && READ_ONCE(control.open) && !READ_ONCE(control.lapsed) &&
	    now > heartbeat && now - heartbeat > grace)
		lapse();
	bpf_timer_start(&d->timer, next_check(), 0);
	return 0;
}

/*
 * Starts the timer. Run once by BPF_PROG_TEST_RUN, because only a program can start a timer.
 * Returns 0 or a negative errno.
 */
SEC("tc")
int gate_arm(struct __sk_buff *skb)
{
	struct deadman *d;
	__u32 key = 0;
	long err;

	d = bpf_map_lookup_elem(&deadman, &key);
	if (!d)
		return -1;
	/* After a restart of the daemon it exists; then only its callback is replaced. */
	bpf_timer_init(&d->timer, &deadman, CLOCK_MONOTONIC);
	err = bpf_timer_set_callback(&d->timer, check_heartbeat);
	if (err)
		return err;
	err = bpf_timer_start(&d->timer, next_check(), 0);
	if (err)
		return err;
	WRITE_ONCE(control.armed, 1);
	return 0;
}

/*
 * The deadline `next`, or an earlier one that gate_until requires. Jiffies are rounded down, and
 * one is subtracted for the one that has begun; if nothing is left, the deadline has passed.
 */
static __always_inline __u64 allowed(__u64 jiffies, __u64 next)
{
	__u32 key = 0;
	struct gate_until *u = bpf_map_lookup_elem(&until, &key);
	__u64 left = 0, end, now;

	if (!u || !READ_ONCE(u->until))
		return next;
	now = bpf_ktime_get_ns();
	if (READ_ONCE(u->until) > now && READ_ONCE(u->tick))
		left = (READ_ONCE(u->until) - now) / READ_ONCE(u->tick);
	end = left ? jiffies + left - 1 : jiffies - 1;
	return end < next ? end : next;
}

/*
 * Moves the deadline. Run by BPF_PROG_TEST_RUN; skb->mark is an enum gate_beat. A beat never opens
 * gates that were closed because of silence: frames may have been dropped, and what the daemon
 * knows may be outdated. A deadline of 0 belongs to a control word that had no heart-beat yet.
 */
SEC("tc")
int gate_beat(struct __sk_buff *skb)
{
	__u64 ticks = READ_ONCE(control.grace_ticks), deadline = READ_ONCE(control.deadline);
	__u64 now = bpf_jiffies64();
	__u64 next = allowed(now, ticks == FOR_EVER ? FOR_EVER : now + ticks);

	if (skb->mark == GATE_BEAT_CLEAR) {
		WRITE_ONCE(control.deadline, next);
		__sync_lock_test_and_set(&control.lapsed, 0);
		return 0;
	}
	if (deadline && now > deadline && READ_ONCE(control.open))
		lapse();
	if (READ_ONCE(control.lapsed) ||
	    (skb->mark == GATE_BEAT_SHORTEN && (!deadline || next > deadline)))
		return 0;
	WRITE_ONCE(control.deadline, next);
	return 0;
}

/*
 * Run by BPF_PROG_TEST_RUN: returns the jiffies until the gates close by themselves; ~0: 2^32 or
 * more.
 */
SEC("tc")
int gate_left(struct __sk_buff *skb)
{
	__u64 deadline = READ_ONCE(control.deadline), now = bpf_jiffies64();

	if (deadline <= now)
		return 0;
	return deadline - now < ~0U ? deadline - now : ~0U;
}

char LICENSE[] SEC("license") = "Dual BSD/GPL";
