// SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause
/*
 * The dead-man: a kernel timer that closes all gates when the daemon's heart-beat word stands
 * still. A value with a timer can't be memory-mapped, so it has a map of its own.
 */
#include <linux/bpf.h>
#include <linux/pkt_cls.h>
#include <linux/time.h> /* CLOCK_MONOTONIC */
#include <bpf/bpf_helpers.h>

#include "bpf/gate.h"
#include "bpf/once.bpf.h"

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

struct gate_control control SEC(".data.control");

static __u64 next_check(void)
{
	__u64 check = READ_ONCE(control.check_ns);

	return check < SHORTEST_CHECK ? SHORTEST_CHECK : check;
}

static int check_heartbeat(void *map, __u32 *key, struct deadman *d)
{
	__u64 grace = READ_ONCE(control.grace_ns);
	/* The heart-beat before the clock: a beat in between must not look like a long silence. */
	__u64 heartbeat = READ_ONCE(control.heartbeat);
	__u64 now = bpf_ktime_get_ns();

	if (grace != FOR_EVER && READ_ONCE(control.open) && !READ_ONCE(control.lapsed) &&
	    now > heartbeat && now - heartbeat > grace) {
		WRITE_ONCE(control.lapsed, 1);
		control.lapses++;
	}
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

char LICENSE[] SEC("license") = "Dual BSD/GPL";
