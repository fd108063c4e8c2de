// SPDX-License-Identifier: BSD-2-Clause
// The records of a cluster as plain structs, and what its protocol reports. How a record is
// written is the business of a Codec.
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
/// Random octets that an operator puts into the store after it was restored.
using Epoch = std::array<std::uint8_t, 16>;

/// Bounds of what is believed of a store. What is above them counts as unreadable.
inline constexpr std::size_t kMostEntryBytes = 65536;
inline constexpr std::size_t kMostReservations = 200'000;
inline constexpr std::size_t kMostChunks = 256;
inline constexpr std::size_t kMostChunkBytes = 32768;
/// Chunks of all descriptions: the one in force, the former and the next one, and what is left.
inline constexpr std::size_t kMostBlobs = 4 * kMostChunks;
/// Networks of one admission, and puts of one transaction.
inline constexpr std::size_t kMostNetworks = 32;
inline constexpr std::size_t kMostPuts = 120;

/// Whether a gateway carries what another one could carry as well.
enum class Role : std::uint8_t {
  standby,  ///< it carries nothing of that
  taking,   ///< it asks the others to leave that to it
  active,   ///< it carries what is its turn
};

/// m/<gateway>: with each transaction of a gateway.
struct Beat {
  std::int64_t incarnation = 0;  ///< revision at which it joined; 0: of this very entry
  std::uint64_t session = 0;     ///< random, of its process
  std::uint64_t seq = 0;         ///< of the transaction
  Digest digest = {};            ///< of the description that it decides from
  std::uint64_t generation = 0;  ///< of that description; 0: it is not in force
  std::int64_t applied = 0;      ///< it has acted on everything up to this revision
  Role role = Role::standby;
  bool draining = false;
  Value lease = 0;
};

/// r/<network>/<gateway>/<id>
struct Taken {
  std::string channel, publisher;
  Part part;
  std::vector<std::size_t> through;  ///< gateways that may send it too
};

/// What becomes of an admission that others must agree to.
enum class Stage : std::uint8_t {
  prepared,  ///< everything is taken, nothing is open
  granted,
  ending,  ///< it is closed where it was asked for, the others are to close it
};

/// x/<gateway>/<id>
struct Asked {
  Stage stage = Stage::prepared;
  std::string admission;              ///< the caller's
  std::vector<std::size_t> gateways;  ///< that must agree
};

/// An admission in the store. `asked`: revision at which x/<gateway>/<id> came to be.
struct Origin {
  std::size_t gateway = 0;
  std::uint64_t id = 0;
  std::int64_t asked = 0;
  auto operator<=>(const Origin&) const = default;
};

struct Vote {
  bool ok = false;
  Place hop;
  std::string reason;  ///< at most 512 bytes, printable
  bool operator==(const Vote&) const = default;
};

/// a/<gateway>/<origin>/<id>
struct VoteOf {
  std::int64_t asked = 0;  ///< see Origin
  Vote vote;
};

/// d/current: the description in force.
struct Current {
  std::uint64_t generation = 0;
  Digest digest = {}, former = {};
  bool open = false;               ///< false: nothing of shared networks may be used
  std::vector<std::string> waits;  ///< gateways that must be in it before it is open
  bool undone = false;             ///< it is the former one, because not all came into the other
};

/// d/next: the description that is to be in force.
struct Next {
  std::uint64_t generation = 0;
  Digest digest = {};
  std::uint32_t chunks = 0;
  std::string by;                    ///< gateway
  std::vector<std::string> without;  ///< gateways that are off, as the operator says
  Value patience = 0;
};

/// d/vote/<gateway>
struct RolloutVote {
  std::int64_t next = 0;  ///< revision of the d/next that it answers, or of the d/current
  bool ok = false;
  std::string reason;
};

/// Records as they are in the store. A record that is not understood is nullopt: of a later
/// version, damaged, or made by somebody hostile. Gateways and networks that the description does
/// not have are not understood either.
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
  [[nodiscard]] virtual std::string write(const Asked& asked) const = 0;
  [[nodiscard]] virtual std::string write(const VoteOf& vote) const = 0;
  [[nodiscard]] virtual std::string write(const Current& current) const = 0;
  [[nodiscard]] virtual std::string write(const Next& next) const = 0;
  [[nodiscard]] virtual std::string write(const RolloutVote& vote) const = 0;
  [[nodiscard]] virtual std::optional<Beat> beat(std::string_view value) const = 0;
  /// `network`: that of the key.
  [[nodiscard]] virtual std::optional<Taken> taken(std::string_view value,
                                                   std::size_t network) const = 0;
  [[nodiscard]] virtual std::optional<Asked> asked(std::string_view value) const = 0;
  [[nodiscard]] virtual std::optional<VoteOf> vote(std::string_view value) const = 0;
  [[nodiscard]] virtual std::optional<Current> current(std::string_view value) const = 0;
  [[nodiscard]] virtual std::optional<Next> next(std::string_view value) const = 0;
  [[nodiscard]] virtual std::optional<RolloutVote> rollout_vote(std::string_view value) const = 0;
  [[nodiscard]] virtual std::optional<Epoch> epoch(std::string_view value) const = 0;
};

/// What a gateway must remember over a restart. Written before what follows from it is done.
struct Journalled {
  Epoch epoch = {};
  std::int64_t epoch_revision = 0;
  std::int64_t incarnation = 0;    ///< 0: it is in no cluster
  std::int64_t seen_revision = 0;  ///< may lag behind; later than `incarnation` or the same
  Digest voted_digest = {};        ///< the last one that it agreed to
  bool operator==(const Journalled&) const = default;
};

/// A description that is to be rolled out.
struct Rollout {
  Digest digest = {};
  std::vector<std::string> chunks;
  std::vector<std::string> without;
};

/// What is known of another gateway.
enum class Alive : std::uint8_t {
  present,
  silent,  ///< it may be dead, and may still send
  fenced,  ///< it is dead, and surely does not send what is leased
  draining,
  standby,
  absent,
};

/// Committed, and open at all gateways on the way: decide again and put it in force.
struct Reserved {
  std::uint64_t id = 0;
  std::int64_t revision = 0;
};
/// Somebody else took something meanwhile, which the view has by now: decide again.
struct Conflict {
  std::uint64_t id = 0;
  std::size_t network = 0;
  std::string by;  ///< "gateway id", as the store has it
  unsigned tries = 0;
};
/// The one answer of an admission that is not granted.
struct Refused {
  std::uint64_t id = 0;
  Vote why;
  std::optional<std::size_t> by;  ///< gateway
};
/// Of an admission that was granted: close it and release it.
struct Withdrawn {
  std::uint64_t id = 0;
  Vote why;
  std::optional<std::size_t> by;
};
/// Everything that is leased closes now, before any further transaction is sent. It is in the
/// store no longer, or will not be soon.
struct Lost {
  std::string why;
};
/// After a start: the store still has this of ours. Release it unless it is in force.
struct Found {
  std::uint64_t id = 0;
  std::string admission;
};
/// This gateway is a member from now on. What is in force and was neither Found before nor is to be
/// adopted by the events that follow at once is not in the store: close it, and ask again.
/// `goes_on`: as the one that it was before.
struct Joined {
  bool goes_on = false;
};
/// Decide about an admission of another gateway, with everything closed, and vote.
struct Adopt {
  Origin origin;
  std::string admission;
  Footprint footprint;
};
/// It is granted everywhere: open it.
struct Opened {
  Origin origin;
};
/// Close it.
struct Ended {
  Origin origin;
  std::string why;
};
struct ForeignChanged {
  std::size_t network = 0;
};
/// Whether a gateway can be chosen to carry what another one could carry as well.
struct Failed {
  std::size_t gateway = 0;
  bool failed = true;
};
/// Another description is to be judged: vote_rollout().
struct Judge {
  Digest digest = {};
  std::string content;
};
/// What became of a rollout that did not come into force, with the first gateway that objected.
struct NotRolledOut {
  std::string why;
};
/// The description in force.
struct Switch {
  Digest digest = {}, former = {};
  std::uint64_t generation = 0;
  bool open = false;
  bool undone = false;
};
struct Drained {};

using Event =
    std::variant<Reserved, Conflict, Refused, Withdrawn, Lost, Found, Joined, Adopt, Opened, Ended,
                 ForeignChanged, Failed, Judge, NotRolledOut, Switch, Drained>;

}  // namespace mlcca::core::cluster
