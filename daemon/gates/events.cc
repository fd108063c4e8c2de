// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/events.hpp"

#include <bpf/bpf.h>
#include <bpf/libbpf.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "daemon/gates/failure.hpp"
#include "daemon/gates/pins.hpp"

namespace mlcca::gates {
namespace {

static_assert(offsetof(gate_event, kind) == 0 && offsetof(gate_sample, kind) == 0);

}  // namespace

void free_ring(ring_buffer* ring) { ring_buffer__free(ring); }

Result<Fd> make_event_ring() {
  Fd made(bpf_map_create(BPF_MAP_TYPE_RINGBUF, "mlcca_events", 0, 0, GATE_EVENTS_SIZE, nullptr));
  if (!made) return failure("ring of events", errno);
  return made;
}

/// If a new ring replaces the former one, only reports are lost: gates that write to the former one
/// pass and drop the same frames.
Result<Fd> open_event_ring(const std::string& pin_path, std::string& was) {
  const auto is_ours = [](int map) { return is_ring(map, GATE_EVENTS_SIZE); };
  auto there = open_own(pin_path, is_ours, was);
  if (!there || *there) return there;
  auto made = make_event_ring();
  if (!made) return made;
  const auto pinned = pin(made->get(), pin_path);
  if (!pinned) return std::unexpected(pinned.error());
  if (*pinned) return made;
  // Another process was first, so its ring is used.
  there = open_own(pin_path, is_ours, was);
  if (there && !*there)
    return fail("pin " + pin_path + ": another program pins there at this moment");
  return there;
}

/// Records of another size come from no gate that is known here, and are skipped. A negative result
/// ends the reading after this record.
int EventReader::take_record(void* context, void* data, std::size_t size) {
  auto& turn = *static_cast<Turn*>(context);
  const int more = ++turn.taken < kAtOnce ? 0 : -EAGAIN;
  if (size < sizeof(std::uint32_t)) return more;
  if (*static_cast<const std::uint32_t*>(data) == GATE_E_UNKNOWN) {
    if (size == sizeof(gate_sample)) turn.take.sample(*static_cast<const gate_sample*>(data));
  } else if (size == sizeof(gate_event)) {
    turn.take.event(*static_cast<const gate_event*>(data));
  }
  return more;
}

Result<EventReader> EventReader::open(int ring, Take take) {
  auto owned = std::make_unique<Turn>(std::move(take));
  Ring reader(ring_buffer__new(ring, take_record, owned.get(), nullptr));
  if (!reader) return failure("read the ring of events", errno);
  return EventReader(std::move(reader), std::move(owned));
}

int EventReader::fd() const { return ring_buffer__epoll_fd(ring_.get()); }

Result<void> EventReader::read() {
  turn_->taken = 0;
  if (const int taken = ring_buffer__consume(ring_.get()); taken < 0 && taken != -EAGAIN)
    return failure("read the ring of events", taken);
  return {};
}

}  // namespace mlcca::gates
