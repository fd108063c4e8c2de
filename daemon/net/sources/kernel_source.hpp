// SPDX-License-Identifier: BSD-2-Clause
// What the sources that ask the kernel have in common: when they look, and what becomes of a look.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "daemon/net/sources/conversation.hpp"
#include "daemon/net/sources/source.hpp"
#include "daemon/net/sources/timer.hpp"

namespace mlcca::net {

/// Looks at once, then each second, and early when the kernel tells that an interface of this
/// network namespace came, went or changed. A look that the kernel did not answer within a second
/// is given up and told as a problem.
class KernelSource : public LinkSource {
 public:
  KernelSource(sd_event* loop, Report report) : loop_(loop), report_(std::move(report)) {}

  Result<void> start();

 protected:
  /// Asks, and ends in exactly one of the tell functions; until then no further look begins. They
  /// destroy the conversations of the look, so they are called last.
  virtual void look() = 0;

  /// Begins a look at a generic netlink family about an interface: `ask` is called with both. That
  /// one of them is not there is told as a problem.
  void look_at_family(const char* family, const std::string& interface,
                      std::function<void(Conversation&, std::uint16_t, unsigned)> ask);
  /// The conversation of this look, opened when first asked for. Nothing if that is impossible,
  /// which is told as a problem.
  Conversation* talk(int protocol);
  void tell(core::mesh::Snapshot snapshot);
  void tell_problem(std::string problem);
  /// The kernel refused: "WHAT: words of the error". A list that changed while it was made (EINTR)
  /// is no problem: nothing is told, and it is looked at again soon.
  void tell_refusal(const std::string& what, int error);
  /// A further look 100 ms after this one instead of a second.
  void look_again_soon();

  /// CLOCK_MONOTONIC, ns, of this turn of the loop.
  [[nodiscard]] std::uint64_t now() const { return time_of(loop_); }

 private:
  struct FreeSocket {
    void operator()(nl_sock* socket) const noexcept;
  };
  void begin();
  void end();
  void look_at(std::uint64_t when);
  void arm(std::uint64_t when);
  void take_notices();
  Result<void> join_notices();

  sd_event* loop_;
  Report report_;
  Timer timer_;
  std::unique_ptr<nl_sock, FreeSocket> notices_;
  EventSource noticed_;
  std::unique_ptr<Conversation> generic_;
  std::unique_ptr<Conversation> route_;
  bool looking_ = false;
  std::uint64_t begun_ = 0;  ///< when the latest look began, CLOCK_MONOTONIC ns
  std::uint64_t next_ = 0;   ///< when the next one is due
};

}  // namespace mlcca::net
