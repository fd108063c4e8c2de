// SPDX-License-Identifier: BSD-2-Clause
// Requests to rtnetlink that wait for their answers. (Those of net/sources/conversation.hpp do not
// wait.) An answer is either complete or an error, and no call waits without limit. A socket on
// which anything has failed is not used again, because messages that are still in it belong to no
// request.
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

/// A request with its fixed part, to which attributes are added. Throws std::bad_alloc if there is
/// no memory.
[[nodiscard]] Message new_message(int type, int flags, const void* head, std::size_t size);

/// The value of an attribute of any length: the text up to its end; the number, or 0.
[[nodiscard]] std::string text_in(const nlattr& attribute);
[[nodiscard]] std::uint32_t number_in(const nlattr& attribute);

/// Why a request has failed.
struct Refusal {
  int said = 0;  ///< the errno of the kernel's answer; 0: it has not answered
  std::string text;
  /// The error for an operation: "reading the interfaces: …".
  [[nodiscard]] std::unexpected<Error> when(const std::string& doing) const;
};

/// The messages of an answer, without the end of a dump and the acknowledgement.
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
  /// Calls `take` with the libnl object of each message of one type (RTM_NEWLINK, …).
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

/// A connection to rtnetlink for requests that wait for their answers.
class Rtnl {
 public:
  /// The limit for a complete request, including repetitions.
  static constexpr std::chrono::milliseconds kLimit{2000};
  /// The most datagrams of an answer that are still read after the limit, because this process had
  /// no processor time.
  static constexpr unsigned kMostLate = 64;
  /// Attempts, if a list has changed while it was read, or something was lost.
  static constexpr int kTries = 5;
  static constexpr std::size_t kMostOctets = std::size_t{64} << 20;  ///< of all answers together

  /// A list that is consistent at one moment.
  std::expected<Answers, Refusal> dump(const Message& request);
  /// A request that changes nothing, so that it can be repeated.
  std::expected<Answers, Refusal> get(const Message& request);
  /// A change, which is acknowledged. After an error without an answer (Refusal::said is 0) it may
  /// have been made.
  std::expected<void, Refusal> change(const Message& request);

  /// The number of sockets that were given up, for tests.
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
