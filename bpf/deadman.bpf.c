// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/*
 * The dead-man closes all gates when the daemon's heart-beat stands still. Each beat moves a
 * deadline in jiffies, which the gates compare with the clock themselves (closed.bpf.h); user space
 * cannot read jiffies, so a beat is a run of gate_beat. A kernel timer is the second line: it
 * counts the lapse while no heart-beat comes. A value with a timer can't be memory-mapped, so it
 * has a map of its own.
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
#define SHORTEST_CHECK 1000000ULL /* ns: a word of 0 must not keep a CPU busy */

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

/* Timer and beat may find the same silence: it is one lapse. */
static __always_inline void lapse(void)
{
	if (!__sync_lock_test_and_set(&control.lapsed, 1))
		__sync_fetch_and_add(&control.lapses, 1);
}

static int check_heartbeat(void *map, __u32 *key, struct deadman *d)
{
	__u64 grace = READ_ONCE(control.grace_ns);
	/* The heart-beat before the clock: a beat in between must not count as a long silence. */
	__u64 heartbeat = READ_ONCE(control.heartbeat);
	__u64 now = bpf_ktime_get_ns();

	if (grace != FOR_EVER && READ_ONCE(control.open) && !READ_ONCE(control.lapsed) &&
	    now > heartbeat && now - heartbeat > grace)
		lapse();
	bpf_timer_start(&d->timer, next_check(), 0);
	return 0;
}

/* Run once by BPF_PROG_TEST_RUN: only a program can start a timer. Gives 0, or a negative errno. */
SEC("tc")
int gate_arm(struct __sk_buff *skb)
{
	struct deadman *d;
	__u32 key = 0;
	long err;

	d = bpf_map_lookup_elem(&deadman, &key);
	if (!d)
		return -1;
	/* It is there already after a restart of the daemon. Then the callback becomes ours. */
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
 * The deadline `next`, or the one before that gate_until allows. Jiffies are rounded down, and one
 * is taken off for that which has begun; where nothing is left the deadline is over already.
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
 * Run by BPF_PROG_TEST_RUN; skb->mark is an enum gate_beat. Gates that have been closed for silence
 * never open by a beat: frames may have been dropped, and what the daemon knows may be old. A
 * deadline of 0 is that of a word for which no heart-beat has come yet.
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

/* Run by BPF_PROG_TEST_RUN: jiffies until the gates close by themselves, ~0: 2^32 and more. */
SEC("tc")
int gate_left(struct __sk_buff *skb)
{
	__u64 deadline = READ_ONCE(control.deadline), now = bpf_jiffies64();

	if (deadline <= now)
		return 0;
	return deadline - now < ~0U ? deadline - now : ~0U;
}

char LICENSE[] SEC("license") = "Dual BSD/GPL";
