// SPDX-License-Identifier: BSD-2-Clause
// What the kernel reports by itself: the ring that all gates of this gateway, and their timers,
// write to.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "base/handle.hpp"
#include "base/result.hpp"
#include "bpf/gate.h"

struct ring_buffer;  // NOLINT(readability-identifier-naming): libbpf's name

namespace mlcca::enforce {

void free_ring(ring_buffer* ring);

/// The ring that all gates share; nothing names it.
Result<Fd> make_event_ring();
/// The pinned ring, or a new one that is pinned there: what was reported while no daemon ran is
/// kept.
Result<Fd> open_event_ring(const std::string& pin_path, std::string& was);

class EventReader {
 public:
  struct Take {
    std::function<void(const gate_event&)> event;
    std::function<void(const gate_sample&)> sample;
  };

  /// `ring` is the map; it may be closed afterwards. Only one reader at a time.
  static Result<EventReader> open(int ring, Take take);

  /// Readable when there are events.
  [[nodiscard]] int fd() const;
  /// Events that one read() takes: the reader has other things to do between two.
  static constexpr int kAtOnce = 64;
  /// Takes what is there, kAtOnce at most.
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

  std::unique_ptr<Turn> turn_;  ///< the ring holds its address
  Ring ring_;
};

}  // namespace mlcca::enforce
