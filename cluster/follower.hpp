// SPDX-License-Identifier: BSD-2-Clause
// What is followed: a snapshot in pages as of one revision, then the changes after it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cluster/channel.hpp"
#include "cluster/etcd.hpp"
#include "cluster/outbox.hpp"

namespace mlcca::cluster {

/// Several prefixes, none within another one.
class Prefixes {
 public:
  explicit Prefixes(std::vector<std::string> all = {});

  [[nodiscard]] const std::vector<std::string>& all() const { return all_; }
  [[nodiscard]] bool has(std::string_view key) const;
  /// The folder that all of them are in, with the slash at its end; empty: there is none.
  [[nodiscard]] std::string folder() const;

 private:
  std::vector<std::string> all_;  ///< rising
};

/// One watch takes the folder of all prefixes: so all changes of a revision come together, and a
/// revision that changed nothing of what is followed is known to have done so.
class Follower {
 public:
  enum class Trouble : std::uint8_t {
    again,    ///< it was too slow, too large or compacted: from the beginning
    refused,  ///< the store refuses it to this user
    broken    ///< of this member
  };
  struct Outside {
    std::function<void(Trouble, const std::string&)> failed;
    std::function<void()> wrote;  ///< there is something in the outbox
  };
  Follower(Outbox& outbox, Outside outside) : outbox_(outbox), outside_(std::move(outside)) {}

  /// From the next start on.
  void set_prefixes(std::vector<std::string> prefixes) {
    prefixes_ = Prefixes(std::move(prefixes));
  }
  [[nodiscard]] bool has_prefixes() const { return !prefixes_.all().empty(); }
  /// From the beginning, through this channel, which stays until stop().
  void start(Channel& channel, std::uint64_t timeout_ms);
  void stop();
  /// The outbox has room again.
  void go_on();
  [[nodiscard]] bool is_active() const { return channel_ != nullptr; }
  /// The snapshot is whole, and changes are awaited.
  [[nodiscard]] bool watches() const { return watching_; }

 private:
  void ask_page();
  void take_page(const std::string& answer);
  void end_page(const End& end);
  void next_prefix();
  void watch();
  void take_changes(const std::string& answer);
  void put_changes(etcd::Changes& changes);
  void fail(Trouble trouble, const std::string& why);

  Outbox& outbox_;
  Outside outside_;
  Prefixes prefixes_;
  Channel* channel_ = nullptr;
  std::uint64_t timeout_ms_ = 0;
  std::unique_ptr<Call> call_;
  std::size_t prefix_ = 0;      ///< whose page is next
  std::string key_;             ///< with which it begins
  std::uint64_t limit_ = 4096;  ///< entries of a page; fewer where they are long
  std::int64_t revision_ = 0;
  bool paging_ = false;
  bool waits_ = false;  ///< for room
  bool watching_ = false;
};

}  // namespace mlcca::cluster
