// SPDX-License-Identifier: BSD-2-Clause
// What is in the store, as it was understood: a value that a snapshot exchanges as a whole.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/cluster/keys.hpp"
#include "core/cluster/lease.hpp"
#include "core/cluster/store.hpp"
#include "core/cluster/types.hpp"
#include "mlcca/arithmetic.hpp"

namespace mlcca::core::cluster {

/// What the store has of a gateway. Without a beat at a revision above 0 it is unreadable.
struct MemberRecord {
  std::int64_t mod = 0;    ///< of m/<gateway>; 0: it is not there
  std::int64_t fence = 0;  ///< of f/<gateway>
  std::optional<Beat> beat;
};
/// Without `taken` it is unreadable.
struct ReservationRecord {
  std::optional<Taken> taken;
  std::int64_t mod = 0;
  Value over_from = kUnbounded;  ///< of a dead gateway, since all on the way have closed it
};
struct AskedRecord {
  Asked asked;
  std::int64_t create = 0, mod = 0;
};
template <class T>
struct Record {
  std::optional<T> value;
  std::int64_t mod = 0;  ///< 0: it is not there; else without a value it is unreadable
};

/// What the store has of a gateway that the description does not have.
struct LeftRecord {
  struct Taken {
    std::size_t network = 0;
    std::int64_t mod = 0;
  };
  MemberRecord member;
  /// By key: what it has taken of networks that the description has.
  std::map<std::string, Taken, std::less<>> taken;
  /// All that there is of it, and what others have written for it, as far as there is room.
  struct Key {
    cluster::Key::Kind kind = cluster::Key::Kind::member;
    std::optional<std::size_t> voter;
    std::int64_t mod = 0;
  };
  std::map<std::string, Key, std::less<>> keys;
};

class Records {
 public:
  struct ReservationKey {
    std::size_t network = 0, gateway = 0;
    std::uint64_t id = 0;
    auto operator<=>(const ReservationKey&) const = default;
  };
  using AskedKey = std::pair<std::size_t, std::uint64_t>;               ///< gateway, id
  using VoteKey = std::tuple<std::size_t, std::size_t, std::uint64_t>;  ///< voter, from, id

  Records() = default;
  Records(std::size_t gateways, std::size_t networks)
      : members(gateways), versions(networks), rollout_votes(gateways) {}

  /// Takes an entry in; the key that it has, if that is understood.
  std::optional<Key> put(const Keys& keys, const Codec& codec, const Entry& entry);
  /// There is something of the network that cannot be read, or more than may be.
  [[nodiscard]] bool unreadable(std::size_t network) const;

  std::vector<MemberRecord> members;
  std::vector<std::int64_t> versions;
  std::map<ReservationKey, ReservationRecord> reservations;
  std::map<AskedKey, AskedRecord> asked;
  std::map<VoteKey, Record<VoteOf>> votes;
  Record<Epoch> epoch;
  Record<Current> current;
  Record<Next> next;
  std::vector<Record<RolloutVote>> rollout_votes;
  /// By digest and number.
  std::map<std::pair<std::string, std::uint64_t>, std::string> blobs;
  /// Keys whose entries are not understood, with the network of which they take something.
  std::map<std::string, std::optional<std::size_t>, std::less<>> strange;
  /// By encoded name.
  std::map<std::string, LeftRecord, std::less<>> left;
  std::size_t left_keys = 0;  ///< of all of them
  bool too_many = false;      ///< stays until the next snapshot

 private:
  void put_reservation(const Codec& codec, const Key& key, const Entry& entry);
  void put_asked(const Codec& codec, const Key& key, const Entry& entry);
  void put_member(const Codec& codec, const Key& key, const Entry& entry);
  void put_blob(const Key& key, const Entry& entry);
  void put_left(const Codec& codec, const LeftKey& key, const Entry& entry);
  void put_description(const Codec& codec, const Key& key, const Entry& entry);
  void note(const Entry& entry, bool understood, std::optional<std::size_t> network);
};

}  // namespace mlcca::core::cluster
