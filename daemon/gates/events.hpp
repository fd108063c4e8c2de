// SPDX-License-Identifier: BSD-2-Clause
// Reports of the kernel: the ring buffer that all gates of this gateway and their timers write to.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "bpf/gate.h"

struct ring_buffer;  // NOLINT(readability-identifier-naming): libbpf's name

namespace mlcca::gates {

void free_ring(ring_buffer* ring);

/// Makes the ring that all gates share, without a pin.
Result<Fd> make_event_ring();
/// Opens the pinned ring, or makes and pins a new one. Reports from the time without a daemon are
/// kept. `was`: what had the name and was replaced.
Result<Fd> open_event_ring(const std::string& pin_path, std::string& was);

/// Reads the ring and calls a function for each record.
class EventReader {
 public:
  struct Take {
    std::function<void(const gate_event&)> event;
    std::function<void(const gate_sample&)> sample;
  };

  /// `ring` is the map's descriptor, which may be closed afterwards. There may be only one reader
  /// at a time.
  static Result<EventReader> open(int ring, Take take);

  /// A descriptor that is readable when there are events.
  [[nodiscard]] int fd() const;
  /// The most events that one read() takes, so that the loop can do other work in between.
  static constexpr int kAtOnce = 64;
  /// Takes the events that are there, kAtOnce at most.
  Result<void> read();

 private:
  struct Turn {
    Take take;
    int taken = 0;
  };
  using Ring = std::unique_ptr<ring_buffer, FreeWith<free_ring>>;
  EventReader(Ring ring, std::unique_ptr<Turn> turn)
      : turn_(std::move(turn)), ring_(std::move(ring)) {}
  static int take_record(void* context, void* data, std::size_t size);

  std::unique_ptr<Turn> turn_;  ///< its address is in the ring, so it must not move
  Ring ring_;
};

}  // namespace mlcca::gates
