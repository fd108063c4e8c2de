// SPDX-License-Identifier: BSD-2-Clause
// The feed of entries from the store to mlccad: a snapshot, requested in pages as of one revision,
// then the changes after that revision.
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

/// A set of key prefixes, none of which is contained in another one.
class Prefixes {
 public:
  explicit Prefixes(std::vector<std::string> all = {});

  [[nodiscard]] const std::vector<std::string>& all() const { return all_; }
  [[nodiscard]] bool has(std::string_view key) const;
  /// The longest common folder of all prefixes, with its final slash; empty if there is none.
  [[nodiscard]] std::string folder() const;

 private:
  std::vector<std::string> all_;  ///< in ascending order
};

/// Reads the snapshot, then watches. One watch covers the common folder of all prefixes: so all
/// changes of a revision come together, and it is known of a revision that it changed nothing that
/// is followed.
class Follower {
 public:
  /// Why following has ended.
  enum class Trouble : std::uint8_t {
    again,  ///< mlccad was too slow, there was too much, or the revision was compacted: start again
    refused,  ///< the store denies access to the user of this gateway
    broken    ///< this member does not work
  };
  struct Outside {
    std::function<void(Trouble, const std::string&)> failed;
    std::function<void()> wrote;  ///< is called when there is something in the outbox
  };
  Follower(Outbox& outbox, Outside outside) : outbox_(outbox), outside_(std::move(outside)) {}

  /// Sets what is followed from the next start() on.
  void set_prefixes(std::vector<std::string> prefixes) {
    prefixes_ = Prefixes(std::move(prefixes));
  }
  [[nodiscard]] bool has_prefixes() const { return !prefixes_.all().empty(); }
  /// Begins with a snapshot. `channel` must stay until stop(). An answer with a page must come
  /// within 5 times `timeout_ms`, because it is large.
  void start(Channel& channel, std::uint64_t timeout_ms);
  void stop();
  /// Must be called when the outbox may have room again.
  void go_on();
  [[nodiscard]] bool is_active() const { return channel_ != nullptr; }
  /// Whether the snapshot is complete and changes are awaited.
  [[nodiscard]] bool watches() const { return watching_; }
  /// Whether changes of that key are reported.
  [[nodiscard]] bool follows(std::string_view key) const { return prefixes_.has(key); }
  /// Whether a change of that revision was not reported, although only changes are awaited.
  [[nodiscard]] bool lacks(std::int64_t revision) const {
    return is_active() && !paging_ && revision_ < revision;
  }

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
  std::size_t prefix_ = 0;  ///< index of the prefix whose page is requested next
  std::string key_;         ///< first key of that page
  /// Entries of a page; reduced when entries are long. For each page etcd counts all entries behind
  /// it, too: with short pages its work grows with the square of the entries.
  std::uint64_t limit_ = 16'384;
  std::int64_t revision_ = 0;
  bool paging_ = false;
  bool waits_ = false;  ///< for room in the outbox
  bool watching_ = false;
};

}  // namespace mlcca::cluster
