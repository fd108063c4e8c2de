// SPDX-License-Identifier: BSD-2-Clause
// Conversations with rtnetlink: the only place where this program asks it for something. An answer
// is complete or an error, no call waits without end, and a socket on which anything failed is not
// used again: messages that are still under way there belong to no question.
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

#include "base/handle.hpp"
#include "base/result.hpp"

struct nl_msg;
struct nlattr;
struct nl_object;

namespace mlcca::net {

struct FreeMessage {
  void operator()(nl_msg* message) const noexcept;
};
using Message = std::unique_ptr<nl_msg, FreeMessage>;

/// The fixed part of a request, to which attributes are added. Throws where there is no memory.
[[nodiscard]] Message new_message(int type, int flags, const void* head, std::size_t size);

/// What an attribute has, however long it is: the text up to its end, the number or 0.
[[nodiscard]] std::string text_in(const nlattr& attribute);
[[nodiscard]] std::uint32_t number_in(const nlattr& attribute);

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
    for (std::size_t at = 0; at < octets_.size();) {
      // NOLINTNEXTLINE(*-reinterpret-cast): octets are what it is made of
      const auto& message = *reinterpret_cast<const nlmsghdr*>(octets_.data() + at);
      take(message);
      at += NLMSG_ALIGN(message.nlmsg_len);
    }
  }
  /// Those of one type (RTM_NEWLINK, …), which libnl makes one kind of object of.
  template <class Take>
  void each_object(int type, Take&& take) const {
    each([type, &take](const nlmsghdr& message) {
      if (message.nlmsg_type != type) return;
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
  /// Datagrams of an answer that are there when it is over, since this process had no processor.
  static constexpr unsigned kMostLate = 64;
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
  enum class Ending : std::uint8_t { done, again };
  struct Read;
  std::expected<Answers, Refusal> ask_again(const Message& request, unsigned flags);
  std::expected<Ending, Refusal> ask_once(const Message& request, unsigned flags, Time end,
                                          Answers& to);
  std::expected<void, Refusal> send(const Message& request, unsigned flags);
  std::expected<bool, Refusal> take(const nlmsghdr& message, Read& read);
  std::expected<std::size_t, Refusal> receive(Time end, unsigned& late);
  std::expected<void, Refusal> wait(int error, Time end);
  std::unexpected<Refusal> give_up(const char* call, int error);
  std::unexpected<Refusal> give_up(std::string why);

  Fd socket_;  ///< made when it is needed
  std::uint32_t sequence_ = 0;
  unsigned replaced_ = 0;
  std::vector<char> buffer_;
};

}  // namespace mlcca::net
