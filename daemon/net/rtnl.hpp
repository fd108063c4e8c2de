// SPDX-License-Identifier: BSD-2-Clause
// Conversations with rtnetlink: the only place where this program asks it for something. An answer
// is whole or an error, nobody waits for ever, and a socket on which anything failed is not used
// again: what is still under way there belongs to no question.
#pragma once
#include <linux/netlink.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "core/handle.hpp"
#include "core/result.hpp"

struct nl_msg;
struct nl_object;

namespace mlcca::net {

struct FreeMessage {
  void operator()(nl_msg* message) const noexcept;
};
using Message = std::unique_ptr<nl_msg, FreeMessage>;

/// The fixed part of a request, to which attributes are added. Throws where there is no memory.
[[nodiscard]] Message new_message(int type, int flags, const void* head, std::size_t size);

struct Refusal {
  int said = 0;  ///< errno that the kernel has answered with, 0: it has not answered
  std::string text;
  /// "reading the interfaces: …"
  [[nodiscard]] std::unexpected<Error> when(const std::string& doing) const;
};

/// Messages one after another, without the end of a dump and the acknowledgement.
class Answers {
 public:
  void add(const nlmsghdr& message);
  [[nodiscard]] std::size_t size() const { return octets_.size(); }
  template <class Take>
  void each(Take&& take) const {
    // NOLINTBEGIN(*-cstyle-cast,*-reinterpret-cast): macros of the kernel's header
    auto left = static_cast<int>(octets_.size());
    for (const auto* head = reinterpret_cast<const nlmsghdr*>(octets_.data()); NLMSG_OK(head, left);
         head = NLMSG_NEXT(head, left))
      take(*head);
    // NOLINTEND(*-cstyle-cast,*-reinterpret-cast)
  }
  /// Each as the object of libnl that it is parsed into.
  template <class Take>
  void each_object(Take&& take) const {
    each([&take](const nlmsghdr& message) {
      parse(
          message,
          [](nl_object* object, void* to) {
            (*static_cast<std::remove_reference_t<Take>*>(to))(object);
          },
          &take);
    });
  }

 private:
  static void parse(const nlmsghdr& message, void (*take)(nl_object*, void*), void* to);
  std::vector<char> octets_;
};

class Rtnl {
 public:
  /// A whole conversation, with all that is asked again.
  static constexpr std::chrono::milliseconds kLimit{2000};
  /// So often is asked what changed while it was read, or got lost on the way.
  static constexpr int kTries = 5;
  static constexpr std::size_t kMostOctets = std::size_t{64} << 20;  ///< of all answers

  /// A list as it was at one moment.
  std::expected<Answers, Refusal> dump(const Message& request);
  /// What is asked changes nothing, so that it can be asked again.
  std::expected<Answers, Refusal> get(const Message& request);
  /// Acknowledged; after an error without an answer it may have been done all the same.
  std::expected<void, Refusal> change(const Message& request);

  /// Sockets that were given up, for tests.
  [[nodiscard]] unsigned replaced() const { return replaced_; }

 private:
  using Time = std::chrono::steady_clock::time_point;
  enum class Ending { done, again };
  struct Read;
  std::expected<Answers, Refusal> ask_again(const Message& request, unsigned flags);
  std::expected<Ending, Refusal> ask_once(const Message& request, unsigned flags, Time end,
                                          Answers& to);
  std::expected<std::size_t, Refusal> receive(Time end);
  std::unexpected<Refusal> give_up(const char* call, int error);
  std::unexpected<Refusal> give_up(std::string why);

  Fd socket_;  ///< made when it is needed
  std::uint32_t sequence_ = 0;
  unsigned replaced_ = 0;
  std::vector<char> buffer_;
};

}  // namespace mlcca::net
