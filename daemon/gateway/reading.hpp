// SPDX-License-Identifier: BSD-2-Clause
// Reads a description on a separate thread, because it may be long, and because its files and the
// users that it names may be slow to look up. The loop continues meanwhile (ADR 28).
#pragma once
#include <systemd/sd-event.h>

#include <cstdint>
#include <functional>
#include <memory>

#include "base/handle.hpp"
#include "daemon/outside/background.hpp"

namespace mlcca {

/// Background work on a thread; one at a time.
class Reading final : public Background {
 public:
  explicit Reading(sd_event* loop) : loop_(loop) {}

  bool begin(std::function<void()> work, std::function<void()> done) override;
  void forget() override;
  [[nodiscard]] bool waits() const override { return static_cast<bool>(done_); }
  [[nodiscard]] std::uint64_t begun() const override { return begun_; }
  [[nodiscard]] bool busy() const override { return static_cast<bool>(source_); }

 private:
  static int on_end(sd_event_source*, int, std::uint32_t, void* self) noexcept;

  sd_event* loop_;
  std::shared_ptr<Fd> ended_;  ///< eventfd that the thread writes to at its end
  std::unique_ptr<sd_event_source, FreeWith<sd_event_source_unref>> source_;
  std::function<void()> done_;
  std::uint64_t begun_ = 0;
};

}  // namespace mlcca
