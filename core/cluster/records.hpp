// SPDX-License-Identifier: BSD-2-Clause
// The contents of the store as they were understood. It is a value, which a new snapshot replaces
// as a unit.
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

/// The beat and fence of one gateway. If `mod` is above 0 and there is no beat, the entry is
/// unreadable, or its lease is not one that a gateway may have.
struct MemberRecord {
  std::int64_t mod = 0;    ///< revision of m/<gateway>; 0: there is no such entry
  std::int64_t fence = 0;  ///< revision of f/<gateway>
  std::optional<Beat> beat;
  Value lease = 0;  ///< as the entry states it, ns; 0: there is none, or it cannot be read
};
/// A reservation. Without `taken` it is unreadable.
struct ReservationRecord {
  std::optional<Taken> taken;
  std::int64_t mod = 0;
  Value over_from = kUnbounded;  ///< for a dead gateway: when it ends, since all gateways on its
                                 ///< way have closed it; kUnbounded: not known yet
};
/// Why an entry is not understood.
enum class Strangeness : std::uint8_t {
  key,       ///< the description has no gateway or network of that name, or it is no key at all
  too_long,  ///< it is longer than kMostEntryBytes
  value,     ///< it is damaged, or of another version
  other,     ///< a reservation under another description
  lease,     ///< a beat with a lease below kLeastLease or above kMostLease
};
/// An entry that is not understood.
struct StrangeEntry {
  std::optional<std::size_t> network;  ///< of which it may reserve something
  Strangeness why = Strangeness::key;
  std::size_t octets = 0;  ///< of its value
};
/// A limit that the entries of the store exceed.
enum class Exceeded : std::uint8_t { no, reservations, strange, changes };
/// A request for an admission that others must agree to: x/<gateway>/<id>.
struct AskedRecord {
  RouteRequest asked;
  std::int64_t create = 0, mod = 0;
};
/// A decoded entry with the revision of its last change.
template <class T>
struct Record {
  std::optional<T> value;
  std::int64_t mod = 0;  ///< 0: there is no such entry; otherwise an entry without a value is
                         ///< unreadable
};

/// The entries of a gateway that the description does not contain (any more).
struct LeftRecord {
  struct Taken {
    std::size_t network = 0;
    std::int64_t mod = 0;
  };
  MemberRecord member;
  /// By key: what it has reserved of described networks.
  std::map<std::string, Taken, std::less<>> taken;
  /// By key: all its entries, and votes that others have written for it, as far as there is room.
  struct Key {
    cluster::Key::Kind kind = cluster::Key::Kind::member;
    std::optional<std::size_t> voter;
    std::int64_t mod = 0;
  };
  std::map<std::string, Key, std::less<>> keys;
};

/// The most entries that are not understood and are remembered by name. With more, all is
/// unreadable.
inline constexpr std::size_t kMostStrange = 4096;

/// All entries of the store, decoded. put() takes one in.
class Records {
 public:
  struct ReservationKey {
    std::size_t network = 0, gateway = 0;
    std::uint64_t id = 0;
    auto operator<=>(const ReservationKey&) const = default;
  };
  using AskedKey = std::pair<std::size_t, std::uint64_t>;               ///< gateway, id
  using VoteKey = std::tuple<std::size_t, std::size_t, std::uint64_t>;  ///< voter, gateway, id

  Records() = default;
  Records(std::size_t gateways, std::size_t networks)
      : members(gateways),
        versions(networks),
        rollout_votes(gateways),
        asked_counts_(gateways),
        vote_counts_(gateways) {}

  /// Takes in an entry, also one that is gone. Returns its key if that was understood.
  std::optional<Key> put(const Keys& keys, const Codec& codec, const Entry& entry);
  /// Whether some reservation of the network cannot be read, or there are more than the limit.
  [[nodiscard]] bool unreadable(std::size_t network) const;

  std::vector<MemberRecord> members;
  std::vector<std::int64_t> versions;
  std::map<ReservationKey, ReservationRecord> reservations;
  /// If there are more than the limit, the gateway with the most requests, or votes, loses some.
  std::map<AskedKey, AskedRecord> asked;
  std::map<VoteKey, Record<VoteOf>> votes;
  Record<Epoch> epoch;
  Record<Current> current;
  Record<Next> next;
  std::vector<Record<RolloutVote>> rollout_votes;
  /// By digest and number of the chunk.
  std::map<std::pair<std::string, std::uint64_t>, std::string> blobs;
  /// By key: entries that are not understood.
  std::map<std::string, StrangeEntry, std::less<>> strange;
  /// By encoded name of the gateway.
  std::map<std::string, LeftRecord, std::less<>> left;
  std::size_t left_keys = 0;         ///< number of keys of all of them
  Exceeded too_many = Exceeded::no;  ///< stays set until the next snapshot

 private:
  void put_reservation(const Codec& codec, const Key& key, const Entry& entry);
  void put_asked(const Codec& codec, const Key& key, const Entry& entry);
  void put_vote(const Codec& codec, const Key& key, const Entry& entry);
  void put_member(const Codec& codec, const Key& key, const Entry& entry);
  void put_blob(const Key& key, const Entry& entry);
  void put_left(const Codec& codec, const LeftKey& key, const Entry& entry);
  void put_description(const Codec& codec, const Key& key, const Entry& entry);
  void note(const Entry& entry, bool understood, std::optional<std::size_t> network,
            Strangeness why = Strangeness::value);

  std::vector<std::size_t> asked_counts_, vote_counts_;  ///< by the gateway that has written them
};

}  // namespace mlcca::core::cluster
