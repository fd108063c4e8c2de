// SPDX-License-Identifier: BSD-2-Clause
// The records of a cluster as plain structs, and the events of its protocol. A Codec defines how
// records are written.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/reserve/parts.hpp"

namespace mlcca::core::cluster {

/// SHA-256 of a description.
using Digest = std::array<std::uint8_t, 32>;
/// Random octets that an operator writes into the store after it was restored from a backup.
using Epoch = std::array<std::uint8_t, 16>;

/// Limits of what is accepted from a store. What exceeds them counts as unreadable.
inline constexpr std::size_t kMostEntryBytes = 65536;
inline constexpr std::size_t kMostReservations = 200'000;
inline constexpr std::size_t kMostChunks = 256;
inline constexpr std::size_t kMostChunkBytes = 32768;
/// Chunks of all descriptions: the present, the former and the next one, and remainders.
inline constexpr std::size_t kMostBlobs = 4 * kMostChunks;
/// Networks of one admission, and puts of one transaction: etcd allows 128 operations.
inline constexpr std::size_t kMostNetworks = 32;
inline constexpr std::size_t kMostPuts = 120;
static_assert(2 * kMostNetworks + 2 <= kMostPuts,
              "two for each network, the own request, and the beat of the member");

/// Whether a gateway carries what another one could carry as well.
enum class Role : std::uint8_t {
  standby,  ///< it carries nothing of that kind
  taking,   ///< it asks the others to leave that to it
  active,   ///< it carries what it is elected for
};

/// m/<gateway>: the beat, written with each transaction of a gateway.
struct Beat {
  std::int64_t incarnation = 0;  ///< revision at which it joined; 0: the revision of this entry
  std::uint64_t session = 0;     ///< random number of its process
  std::uint64_t seq = 0;         ///< number of the transaction
  Digest digest = {};            ///< of the description from which it decides
  std::uint64_t generation = 0;  ///< generation of that description; 0: it is not in force
  std::int64_t applied = 0;      ///< it has acted on everything up to this revision
  Role role = Role::standby;
  bool draining = false;
  Value lease = 0;
};

/// r/<network>/<gateway>/<id>: a reservation.
struct Taken {
  std::string channel, publisher;
  Part part;
  std::vector<std::size_t> through;  ///< gateways on its way, which may send it too
};

/// The progress of an admission that other gateways must agree to.
enum class Stage : std::uint8_t {
  prepared,  ///< everything is reserved, nothing is open
  granted,
  ending,  ///< it is closed at the gateway that asked; the others are to close it
};

/// x/<gateway>/<id>: a request to the gateways on the way of an admission.
struct RouteRequest {
  Stage stage = Stage::prepared;
  std::string admission;              ///< in the encoding of the caller
  std::vector<std::size_t> gateways;  ///< whose agreement is needed
  /// The other gateway for which it is made, as `admission` says; nothing: it is for nobody else.
  std::optional<std::size_t> made_for = std::nullopt;
};

/// Identifies an admission in the store. `asked` is the revision at which x/<gateway>/<id> was
/// created.
struct Origin {
  std::size_t gateway = 0;
  std::uint64_t id = 0;
  std::int64_t asked = 0;
  auto operator<=>(const Origin&) const = default;
};

/// A decision about an admission of another gateway.
struct Vote {
  bool ok = false;
  std::optional<Place> hop;  ///< network or gateway where it does not fit, if it is about one
  std::string reason;        ///< at most 512 bytes, printable
  /// Of a refusal: what it was asked for is gone, so that there is no use in asking again.
  bool final = false;
  /// Another gateway that has refused what this vote depends on, or that was quicker.
  std::optional<std::size_t> gateway = std::nullopt;
  bool operator==(const Vote&) const = default;
};

/// a/<gateway>/<origin>/<id>: a vote.
struct VoteOf {
  std::int64_t asked = 0;  ///< see Origin
  Vote vote;
};

/// d/current: the description in force.
struct Current {
  std::uint64_t generation = 0;
  Digest digest = {}, former = {};
  bool open = false;               ///< if false, nothing of shared networks may be used
  std::vector<std::string> waits;  ///< gateways that must follow it before it is open
  bool undone = false;  ///< it is the former one again, because not all followed the other
};

/// d/next: the proposed description.
struct Next {
  std::uint64_t generation = 0;
  Digest digest = {};
  std::uint32_t chunks = 0;
  std::string by;                    ///< name of the gateway that proposes it
  std::vector<std::string> without;  ///< gateways that are switched off, according to the operator
  Value patience = 0;
  bool force = false;  ///< the operator wants it although deliveries lose their grants
};

/// d/vote/<gateway>: a vote on a proposed description, or against the one in force.
struct RolloutVote {
  std::int64_t next = 0;  ///< revision of the d/next that it answers, or of the d/current
  bool ok = false;
  std::string reason;
};

/// Encodes and decodes the records of the store. A decoder returns nullopt for a record that it
/// does not understand: of a later version, damaged or hostile, or one with gateways or networks
/// that the description does not contain.
class Codec {
 public:
  Codec() = default;
  Codec(const Codec&) = delete;
  Codec& operator=(const Codec&) = delete;
  Codec(Codec&&) = delete;
  Codec& operator=(Codec&&) = delete;
  virtual ~Codec() = default;
  [[nodiscard]] virtual std::string write(const Beat& beat) const = 0;
  [[nodiscard]] virtual std::string write(const Taken& taken) const = 0;
  [[nodiscard]] virtual std::string write(const RouteRequest& asked) const = 0;
  [[nodiscard]] virtual std::string write(const VoteOf& vote) const = 0;
  [[nodiscard]] virtual std::string write(const Current& current) const = 0;
  [[nodiscard]] virtual std::string write(const Next& next) const = 0;
  [[nodiscard]] virtual std::string write(const RolloutVote& vote) const = 0;
  [[nodiscard]] virtual std::optional<Beat> beat(std::string_view value) const = 0;
  /// `network`: index of the network in the record's key.
  [[nodiscard]] virtual std::optional<Taken> taken(std::string_view value,
                                                   std::size_t network) const = 0;
  /// Whether a record that taken() does not understand says of itself that it belongs to another
  /// description. Such a record is as unknown as a damaged one, and only explained otherwise.
  [[nodiscard]] virtual bool of_other_description(std::string_view taken) const = 0;
  [[nodiscard]] virtual std::optional<RouteRequest> asked(std::string_view value) const = 0;
  [[nodiscard]] virtual std::optional<VoteOf> vote(std::string_view value) const = 0;
  [[nodiscard]] virtual std::optional<Current> current(std::string_view value) const = 0;
  [[nodiscard]] virtual std::optional<Next> next(std::string_view value) const = 0;
  [[nodiscard]] virtual std::optional<RolloutVote> rollout_vote(std::string_view value) const = 0;
  [[nodiscard]] virtual std::optional<Epoch> epoch(std::string_view value) const = 0;
};

/// What a gateway must remember over a restart. It is written before anything that depends on it is
/// done.
struct Journalled {
  Epoch epoch = {};
  std::int64_t epoch_revision = 0;
  std::int64_t incarnation = 0;    ///< 0: it is not a member of a cluster
  std::int64_t seen_revision = 0;  ///< may lag behind; never earlier than `incarnation`
  Digest voted_digest = {};        ///< the description that it last agreed to
  bool gone_back = false;  ///< the store has gone back in that epoch; over when it joins in another
  bool waits = false;      ///< leases from before that epoch may not have ended
  bool operator==(const Journalled&) const = default;
};

/// A description that is to be rolled out. `without`: gateways that are called off.
struct Rollout {
  Digest digest = {};
  std::vector<std::string> chunks;
  std::vector<std::string> without;
  bool force = false;  ///< see Next
};

/// What is known of another gateway.
enum class Alive : std::uint8_t {
  present,
  silent,  ///< its lease may have ended, and it may still send
  fenced,  ///< it is dead, and surely sends nothing that is leased
  draining,
  standby,
  absent,
};

/// The reservation is committed, and open at all gateways on the way: decide again and put it in
/// force.
struct Reserved {
  std::uint64_t id = 0;
  std::int64_t revision = 0;
};
/// Another gateway reserved something meanwhile, which the view contains by now: decide again.
struct Conflict {
  std::uint64_t id = 0;
  std::size_t network = 0;
  std::string by;  ///< "gateway id" or "gateway id (for another gateway)", as in the store
  unsigned tries = 0;
};
/// The answer to an admission that is not granted. There is exactly one answer.
struct Refused {
  std::uint64_t id = 0;
  Vote why;
  std::optional<std::size_t> by;  ///< index of the gateway that refused it
};
/// A granted admission is withdrawn: close it and release it.
struct Withdrawn {
  std::uint64_t id = 0;
  Vote why;
  std::optional<std::size_t> by;
};
/// The membership is lost or about to be: close everything that is leased at once, before any
/// further transaction is sent.
struct Lost {
  std::string why;
};
/// After a start: the store still contains this reservation of this gateway. Release it unless it
/// is in force.
struct Found {
  std::uint64_t id = 0;
  std::string admission;
};
/// This gateway is a member from now on. Whatever is in force, but was not reported by Found and is
/// not adopted by the events that follow at once, is not in the store: close it and ask again.
/// `goes_on`: the former incarnation continues.
struct Joined {
  bool goes_on = false;
};
/// Decide about an admission of another gateway, with everything of it closed, and vote.
struct Adopt {
  Origin origin;
  std::string admission;
  Footprint footprint;
};
/// The admission is granted everywhere: open it.
struct Opened {
  Origin origin;
};
/// The admission has ended: close it.
struct Ended {
  Origin origin;
  std::string why;
};
/// What others hold of a network has changed.
struct ForeignChanged {
  std::size_t network = 0;
};
/// A gateway has failed, or can be elected again, to carry what another one could carry.
struct Failed {
  std::size_t gateway = 0;
  bool failed = true;
};
/// Judge this proposed description and answer with vote_rollout().
struct Judge {
  Digest digest = {};
  std::string content;
  bool force = false;  ///< see Next
};
/// A rollout did not come into force; `why` names the first gateway that objected.
struct NotRolledOut {
  std::string why;
};
/// Another description is in force, or its state has changed.
struct Switch {
  Digest digest = {}, former = {};
  std::uint64_t generation = 0;
  bool open = false;
  bool undone = false;
};
/// This gateway has left its cluster.
struct Drained {};

using Event =
    std::variant<Reserved, Conflict, Refused, Withdrawn, Lost, Found, Joined, Adopt, Opened, Ended,
                 ForeignChanged, Failed, Judge, NotRolledOut, Switch, Drained>;

}  // namespace mlcca::core::cluster
