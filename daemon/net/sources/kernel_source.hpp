// SPDX-License-Identifier: BSD-2-Clause
// The common part of the sources that ask the kernel: when they poll, and how a poll ends.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "base/loop_timer.hpp"
#include "daemon/net/sources/conversation.hpp"
#include "daemon/net/sources/source.hpp"

namespace mlcca::net {

/// Polls at once, then each second, and earlier when the kernel reports that an interface of this
/// network namespace has appeared, gone or changed. A poll that the kernel does not answer within a
/// second is given up and reported as a problem.
class KernelSource : public LinkSource {
 public:
  KernelSource(sd_event* loop, Report report) : loop_(loop), report_(std::move(report)) {}

  Result<void> start();

 protected:
  /// Makes the requests of a poll, and ends with exactly one call of a report function; until then
  /// no further poll begins. The report functions destroy the conversations of the poll, so they
  /// must be called last.
  virtual void poll() = 0;

  /// Requests the rtnetlink message of an interface: `each` gets it, then `end` is called. If there
  /// is no such interface, that is reported as a problem and `end` is not called.
  ///
  /// if_nametoindex(3) is not used: for an unknown name the kernel would start modprobe and wait
  /// for it.
  void ask_link(const std::string& interface, Conversation::OnMessage each,
                std::function<void()> end);
  /// Prepares a request to a generic netlink family about an interface: `ask` is called with the
  /// conversation, the number of the family and the index. If family or interface does not exist,
  /// that is reported as a problem.
  void ask_family(const char* family, const std::string& interface,
                  std::function<void(Conversation&, std::uint16_t, unsigned)> ask);
  /// The conversation of this poll, which is opened when first requested; nullptr if that is
  /// impossible, which is reported as a problem.
  Conversation* talk(int protocol);
  void report(core::mesh::Snapshot snapshot);
  void report_problem(std::string problem);
  /// Reports that the kernel refused: "WHAT: words of the error". If a list changed while it was
  /// made (EINTR) nothing is reported, and the next poll comes soon.
  void report_refusal(const std::string& what, int error);
  /// Makes the next poll come 100 ms after this one instead of a second.
  void poll_again_soon();

  /// The time of this turn of the loop: CLOCK_MONOTONIC, ns.
  [[nodiscard]] std::uint64_t now() const { return loop_time(loop_); }

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
  LoopTimer timer_;
  std::unique_ptr<nl_sock, FreeSocket> notices_;
  EventSource noticed_;
  std::unique_ptr<Conversation> generic_;
  std::unique_ptr<Conversation> route_;
  bool polling_ = false;
  std::uint64_t begun_ = 0;  ///< when the latest poll began, CLOCK_MONOTONIC ns
  std::uint64_t next_ = 0;   ///< when the next poll is due
};

}  // namespace mlcca::net
