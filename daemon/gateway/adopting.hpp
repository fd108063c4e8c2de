// SPDX-License-Identifier: BSD-2-Clause
// Handles admissions that other gateways of the cluster have made and whose route crosses this
// gateway. This gateway votes on them, and carries them until they end. They are not in its
// journal, and it cannot release them. The same holds for admissions that this gateway makes for
// another one, because it has admitted the publisher.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/result.hpp"
#include "core/admission/state.hpp"
#include "core/cluster/fair_queue.hpp"
#include "core/cluster/member.hpp"
#include "daemon/cluster/record_codec.hpp"
#include "daemon/gateway/adopted_admissions.hpp"
#include "daemon/gateway/request_index.hpp"
#include "daemon/gateway/reserving.hpp"
#include "daemon/gateway/shared_networks.hpp"

namespace mlcca {

class Adopting {
 public:
  using Number = SharedNetworks::Number;
  using Refusal = Reserving::Refusal;

  /// What adopting needs of the membership.
  class Hands {
   public:
    Hands() = default;
    Hands(const Hands&) = delete;
    Hands& operator=(const Hands&) = delete;
    Hands(Hands&&) = delete;
    Hands& operator=(Hands&&) = delete;
    virtual ~Hands() = default;

    /// Takes the admissions out of the state, and out of the gates if they follow it already.
    virtual void remove(const std::vector<core::AdmissionId>& gone) = 0;
    /// Reserves; an error says why no further job can wait.
    virtual Result<void> reserve(Reserving::Job job) = 0;
    /// Ends the job for the request that was adopted under that number.
    virtual void forget(Number adopted) = 0;
    /// Whether this gateway still wants what it has asked for under that number of its own.
    [[nodiscard]] virtual bool wants(Number number) const = 0;
    /// Nothing more needs to be reserved for these admissions.
    virtual void give_back(const std::vector<core::AdmissionId>& gone) = 0;
    /// The name of a gateway.
    [[nodiscard]] virtual std::string name_of(std::size_t gateway) const = 0;
    [[nodiscard]] virtual core::AdmissionId new_id() = 0;
    [[nodiscard]] virtual Number new_number() = 0;
    /// Brings gates and state in line with what has changed. False if the kernel has refused.
    virtual bool bring_in_line() = 0;
  };
  /// All references must outlive this object.
  Adopting(SharedNetworks& networks, AdoptedAdmissions& admissions, Hands& hands)
      : networks_(networks), admissions_(admissions), hands_(hands) {}

  void on(const core::cluster::Adopt& event);
  void on(const core::cluster::Opened& event);
  void on(const core::cluster::Ended& event);
  /// The connection to the store is lost: everything that was adopted is closed and no longer
  /// counted.
  void lost();
  /// Forgets everything without closing it, where the state that held it is gone already.
  void forget();
  /// After a start the store has this reservation of this gateway, which was made for another one.
  /// True if it is to be kept: the request of the other one follows, or it is given back in step().
  [[nodiscard]] bool keep_found(const cluster::StoredRequest& asked);
  /// What is decided of that channel has changed: what this gateway has agreed to may not be
  /// granted any more.
  void note_changed(std::size_t channel) { changed_.insert(channel); }
  /// Publishers may have gone for which subscribers of other gateways were admitted here.
  void publishers_gone();
  /// What was reserved for an admission that was made for another gateway was withdrawn.
  void withdrawn(core::AdmissionId id, const Refusal& why);
  /// This gateway does not want any more what it has asked for under that number of its own: closes
  /// what another gateway has made for it.
  void close_made_for(Number number);
  /// The most requests of one other gateway that are decided and carried. What it asks for beyond
  /// that is refused.
  static constexpr std::size_t kMostOfGateway = 16'384;
  /// A turn of the loop begins: step() may do as much as is done in one turn.
  void begin_turn() { done_in_turn_ = 0; }
  /// Opens and votes on what is due, as far as one turn allows: what is to be opened comes first,
  /// and gateways take turns. True if anything was done.
  bool step(core::cluster::Member& member, Value now);
  /// Whether step() has more to do in the next turn.
  [[nodiscard]] bool has_due() const {
    return !votes_.empty() || !others_due_.empty() || !to_judge_.empty();
  }
  /// Whether all that the store says to be open is open, or was refused.
  [[nodiscard]] bool has_opened() const { return others_due_.empty(); }
  /// Adds the open admissions to another state of the same description.
  void restore() const;
  [[nodiscard]] bool has(core::AdmissionId id) const;
  /// The request of an admission that has this number of this gateway; null: there is none.
  [[nodiscard]] const control::Request* request_of(core::AdmissionId id) const;
  /// Whether another gateway has made that admission for this one, which has one of its own for the
  /// same subscriber.
  [[nodiscard]] bool is_twin(core::AdmissionId id) const;

 private:
  using Key = RequestIndex<>::Admission;
  enum class Due : std::uint8_t { nothing, vote, open, resume, answer };
  /// Identifies an admission that was made for another gateway: its name and its own number.
  using For = std::pair<std::string, std::uint64_t>;
  struct Adopted {
    core::cluster::Origin origin;
    core::cluster::Footprint footprint;
    std::string text;  ///< of the request, until it is due
    std::optional<cluster::StoredRequest> asked;
    Number number = 0;
    std::vector<WhichRequest> asks;      ///< of `asked`: first `also`, then `requests`
    std::vector<control::Request> ours;  ///< requests that it holds, with numbers of this gateway
    std::vector<WhichRequest> theirs;    ///< the same requests
    Due due = Due::nothing;
    bool open = false;
    std::string refusal{};         ///< why it is not decided; empty: it is
    bool replaced = false;         ///< the other gateway has given its number to something else
    core::cluster::Vote answer{};  ///< of Due::answer
    /// This gateway makes the admission itself; `ours` has the one request.
    [[nodiscard]] bool is_on_behalf() const { return asked && asked->on_behalf; }
  };

  static constexpr const char* kAskedBefore = "it was asked for before";
  static core::cluster::Vote vote_of(Refusal why);
  static Key key_of(const Adopted& adopted) { return {adopted.origin.gateway, adopted.origin.id}; }
  void set_due(Adopted& adopted, Due due);
  void set_not_due(const Key& key);
  [[nodiscard]] Adopted* next_due();
  void read(Adopted& adopted);
  void list(Adopted& adopted);
  void unlist(Adopted& adopted);
  void set_open(Adopted& adopted, bool open);
  void hold(Adopted& adopted, const WhichRequest& which, control::Request ours);
  void hold_nothing(Adopted& adopted);
  void replace(Adopted& former);
  [[nodiscard]] std::string end_former(const Adopted& adopted, const WhichRequest& which);
  void move_request(Adopted& from, const WhichRequest& which, Adopted& to);
  [[nodiscard]] const control::Request* ours_of(const WhichRequest& which) const;
  [[nodiscard]] static bool is_also(const Adopted& adopted, const WhichRequest& which);
  [[nodiscard]] std::vector<core::AdmissionId> all_ours(const Adopted& adopted,
                                                        std::size_t first = 0) const;
  [[nodiscard]] control::Request with_own_number(control::Request request) const;
  [[nodiscard]] std::string name_request(Adopted& adopted, const control::Request& request,
                                         const WhichRequest& which);
  [[nodiscard]] std::string name_all(Adopted& adopted);
  [[nodiscard]] Refusal misfit(const Adopted& adopted) const;
  [[nodiscard]] Refusal misfit_now(const Adopted& adopted);
  [[nodiscard]] Refusal misfit_of_held(const Adopted& adopted) const;
  [[nodiscard]] std::optional<core::cluster::Footprint> mapped(const Adopted& adopted) const;
  [[nodiscard]] std::string open(Adopted& adopted);
  [[nodiscard]] std::string admit_all(const Adopted& adopted) const;
  void close(Adopted& adopted);
  void end(Adopted& adopted, const Refusal& why);
  bool take_back_lost();
  [[nodiscard]] Adopted* other_with(const Adopted& adopted, const WhichRequest& which);
  void hand_on(Adopted& adopted);
  void vote(Adopted& adopted, core::cluster::Member& member, Value now);
  void act_on(Adopted& adopted, core::cluster::Member& member, Value now);
  /// Identifies what was adopted: the same request can be adopted again, under another number.
  struct Ref {
    core::cluster::Origin origin;
    Number number = 0;
  };
  [[nodiscard]] Adopted* find(const Ref& ref);
  [[nodiscard]] bool is_made_for_this(const Adopted& adopted) const;
  [[nodiscard]] bool is_unwanted(const Adopted& adopted) const;
  void answer(Adopted& adopted, const Refusal& why);
  [[nodiscard]] const Adopted* holder_of(core::AdmissionId id) const;
  void begin_on_behalf(Adopted& adopted);
  void resume(Adopted& adopted);
  [[nodiscard]] bool ends_with_publisher(Adopted& adopted);
  [[nodiscard]] std::optional<Reserving::Wish> wish_on_behalf(const Ref& ref);
  [[nodiscard]] bool open_on_behalf(const Ref& ref);

  SharedNetworks& networks_;
  AdoptedAdmissions& admissions_;
  Hands& hands_;
  std::map<Key, Adopted> adopted_;
  RequestIndex<> requests_;                   ///< of all of them
  std::map<core::AdmissionId, Key> holders_;  ///< by the numbers of this gateway that they hold
  std::map<Number, std::set<Key>> made_for_this_;  ///< by the numbers with which it has asked
  std::set<Key> on_behalf_;
  // What is due in step(): votes, and all else, which comes first.
  core::cluster::FairQueue votes_, others_due_;
  std::size_t done_in_turn_ = 0;
  std::map<std::size_t, std::size_t> requests_of_;  ///< by gateway: how many are decided
  std::set<Key> to_check_;                          ///< their publishers may have gone
  std::set<std::size_t> changed_;                   ///< channels, see note_changed()
  std::set<Key> to_judge_;                          ///< something of them is not granted any more
  std::map<For, control::Request> found_;  ///< reserved by an earlier process, see keep_found()
};

}  // namespace mlcca
