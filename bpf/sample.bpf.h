/* SPDX-License-Identifier: GPL-2.0-only OR BSD-2-Clause */
/*
 * Reports unknown frames by the ring buffer that all gates share. The clock (with the resolution of
 * a tick) is read only for frames that are not among the latest of this CPU: a single flooding
 * sender is reported once by each CPU, and then costs no time.
 */
#ifndef MLCCA_SAMPLE_BPF_H
#define MLCCA_SAMPLE_BPF_H

struct {
	__uint(type, BPF_MAP_TYPE_RINGBUF);
	__uint(max_entries, GATE_EVENTS_SIZE);
} events SEC(".maps");

static __always_inline void report_sample(struct gate_sample *sample, __u64 *due)
{
	sample->kind = GATE_E_UNKNOWN;
	if (!take_turn(due, GATE_SAMPLE_NS, (GATE_SAMPLES - 1) * GATE_SAMPLE_NS,
		       bpf_ktime_get_coarse_ns()) ||
	    bpf_ringbuf_query(&events, BPF_RB_AVAIL_DATA) >= GATE_EVENTS_SIZE / 2)
		return;
	sample->at = bpf_ktime_get_ns();
	bpf_ringbuf_output(&events, sample, sizeof(*sample), 0);
}

#endif
