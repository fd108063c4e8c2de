// SPDX-License-Identifier: BSD-2-Clause
// What the sources that ask the kernel have in common: when they poll, and how a poll ends.
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

/// Polls at once, then each second, and early when the kernel reports that an interface of this
/// network namespace came, went or changed. A poll that the kernel did not answer within a second
/// is given up and reported as a problem.
class KernelSource : public LinkSource {
 public:
  KernelSource(sd_event* loop, Report report) : loop_(loop), report_(std::move(report)) {}

  Result<void> start();

 protected:
  /// Asks, and ends in exactly one of the report functions; until then no further poll begins. They
  /// destroy the conversations of the poll, so they are called last.
  virtual void poll() = 0;

  /// Asks for the rtnetlink message of an interface: `each` gets it, then `end` is called. If there
  /// is no such interface that is reported as a problem, and `end` is not called.
  ///
  /// if_nametoindex(3) would let the kernel start modprobe for a name that it does not know, and
  /// wait for it.
  void ask_link(const std::string& interface, Conversation::OnMessage each,
                std::function<void()> end);
  /// Asks a generic netlink family about an interface: `ask` is called with both. If one of them is
  /// not there, that is reported as a problem.
  void ask_family(const char* family, const std::string& interface,
                  std::function<void(Conversation&, std::uint16_t, unsigned)> ask);
  /// The conversation of this poll, opened when first asked for. Nothing if that is impossible,
  /// which is reported as a problem.
  Conversation* talk(int protocol);
  void report(core::mesh::Snapshot snapshot);
  void report_problem(std::string problem);
  /// The kernel refused: "WHAT: words of the error". A list that changed while it was made (EINTR)
  /// is no problem: nothing is reported, and the next poll comes soon.
  void report_refusal(const std::string& what, int error);
  /// A further poll 100 ms after this one instead of a second.
  void poll_again_soon();

  /// CLOCK_MONOTONIC, ns, of this turn of the loop.
  [[nodiscard]] std::uint64_t now() const { return time_of(loop_); }

 private:
  struct FreeSocket {
    void operator()(nl_sock* socket) const noexcept;
  };
  void begin();
  void end();
  void poll_at(std::uint64_t when);
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
  bool polling_ = false;
  std::uint64_t begun_ = 0;  ///< when the latest poll began, CLOCK_MONOTONIC ns
  std::uint64_t next_ = 0;   ///< when the next one is due
};

}  // namespace mlcca::net
