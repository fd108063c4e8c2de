// SPDX-License-Identifier: BSD-2-Clause
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "core/cluster/footprint.hpp"
#include "daemon/cluster/record_codec.hpp"
#include "daemon/gateway/cluster_session.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/recorder.hpp"
#include "daemon/gateway/reserving.hpp"
#include "daemon/gateway/scene.hpp"

namespace mlcca {

/// The wishes of this gateway: reservations on shared networks for channels that exist already.
class Wishes {
 public:
  /// All must outlive this.
  struct Parts {
    const Scene& scene;
    const Recorder& recorder;
    EventLog& log;
    const Clock& clock;
    ClusterSession& session;
    std::function<void(Reserving::Job)> ask;
  };
  explicit Wishes(Parts parts) : parts_(std::move(parts)) {}

  /// Asks for one channel that would be given more with a reservation. True if there was one.
  bool ask_for_one();
  /// Everything may be asked for at once, even what was tried a short time ago: a gateway has
  /// failed, for example, and what it carried is to be reserved now.
  void anew();
  /// To be called now and then.
  void forget_past_pauses();
  /// Another gateway has ended what was reserved for the channel over these gateways: it is asked
  /// for again soon, also if it was granted only a short time ago.
  void note_withdrawal(const std::string& channel, std::vector<std::size_t> gateways,
                       const Reserving::Refusal& why);
  /// Another gateway, or one that was quicker, has kept the channel from being reserved over those
  /// gateways. Without a gateway in `why` nobody has objected.
  void note_objection(const std::string& channel, std::vector<std::size_t> gateways,
                      const Reserving::Refusal& why);
  /// Another description begins.
  void forget_objections() { objections_.clear(); }
  /// The latest objection to the channel over some of these gateways, as Holdings::objection().
  [[nodiscard]] std::string objection(const std::string& channel,
                                      std::span<const std::size_t> gateways) const;

  /// Adds to `to` the admissions here that the deliveries of a newcomer need beside its own,
  /// because other gateways on the way have not agreed to any of them: subscribers that were
  /// without a publisher. To be called before add_publishers().
  void add_subscribers(const core::Proposal& wish, cluster::StoredRequest& to) const;
  /// Adds to `to` the admissions here that have brought the publishers that `footprint` counts.
  /// Other gateways need them to decide on it.
  void add_publishers(const core::cluster::Footprint& footprint, cluster::StoredRequest& to) const;
  /// Whether what the store has as asked for by this gateway is what it has admitted.
  [[nodiscard]] bool is_known(const cluster::StoredRequest& asked) const;
  /// Whether this gateway still has the admissions whose publishers it counts.
  [[nodiscard]] bool has_publishers_of(const cluster::StoredRequest& asked) const;
  /// Whether a granted delivery of its channel needs a reservation: no other one has what the
  /// delivery takes, or the agreement of the gateways on its way.
  [[nodiscard]] bool needs(SharedNetworks::Number number, const Reserving::Held& held) const {
    return !uses_of(number, held).empty();
  }
  /// What is to be reserved for these deliveries instead of it; nullopt if there are none.
  [[nodiscard]] std::optional<Reserving::Wish> rest_of(SharedNetworks::Number number,
                                                       const Reserving::Held& held) const;

 private:
  struct Wished {
    std::vector<std::size_t> gateways;  ///< other gateways on the way
    std::vector<core::Delivery> deliveries;
    bool all = true;  ///< of that way
  };
  /// A channel and the other gateways on its way, by rising index.
  using Way = std::pair<std::string, std::vector<std::size_t>>;

  void wish(std::size_t channel);
  [[nodiscard]] std::optional<Reserving::Wish> wish_next(const std::string& channel,
                                                         Wished& wished);
  [[nodiscard]] bool are_there(const std::string& channel,
                               const std::vector<std::size_t>& gateways);
  [[nodiscard]] bool is_granted(const std::string& channel, const Wished& wished) const;
  [[nodiscard]] std::optional<Reserving::Wish> wish_of(const std::string& channel,
                                                       const core::Proposal& proposal,
                                                       core::cluster::Want& want) const;
  [[nodiscard]] cluster::StoredRequest asked_of(const std::string& channel,
                                                core::cluster::Want& want) const;
  [[nodiscard]] bool takes_part(const core::Verdict& verdict,
                                std::span<const core::AdmissionId> ids) const;
  [[nodiscard]] const control::Request* request_of(core::AdmissionId id) const;
  using Deliveries = std::vector<const core::Verdict*>;
  [[nodiscard]] Deliveries uses_of(SharedNetworks::Number number,
                                   const Reserving::Held& held) const;
  [[nodiscard]] core::State& state() const { return *parts_.scene.state; }
  [[nodiscard]] Value now() const { return parts_.clock.monotonic_ns(); }

  Parts parts_;
  std::map<std::string, Value> wish_again_;  ///< when a channel's wish is tried again, by channel
  /// The same of one of its wants: by channel and the other gateways on the way.
  std::map<Way, Value> want_again_;
  struct Objection {
    std::size_t gateway = 0;
    std::string why;
  };
  std::map<Way, Objection> objections_;
};

}  // namespace mlcca
