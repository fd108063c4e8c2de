// SPDX-License-Identifier: BSD-2-Clause
// The subscriptions of a gateway: those of peers and its own.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "control/messages.hpp"
#include "relay/famouso/subscription.hpp"

namespace mlcca::relay {

/// Keeps the subscriptions of peers on the gateway's networks, which the daemon decides and which
/// are answered, and the gateway's own ones, which pass on the requirements towards the publishers.
/// It does no I/O: messages, replies and the time (CLOCK_MONOTONIC, ns) are arguments.
class Subscriptions {
 public:
  /// Time (ns) between two messages of an own subscription; its lease is three times that.
  static constexpr std::uint64_t kRenewal = 20'000'000'000;
  /// The leases (s) of peers are limited to this range.
  static constexpr std::uint16_t kShortestLease = 10;
  static constexpr std::uint16_t kLongestLease = 3'600;
  /// For this time (ns) a refusal is repeated without asking the daemon, even if something has
  /// changed, because each refused request is itself reported as an event of the subject.
  static constexpr std::uint64_t kRefusalHolds = 10'000'000'000;
  /// Unanswered requests to the daemon.
  static constexpr std::size_t kMostAsked = 64;
  /// Gateways on the way of a subscription.
  static constexpr std::uint8_t kHops = 8;
  /// Gateways whose answers to one own subscription are kept.
  static constexpr std::size_t kMostAnswers = 16;

  /// What the class needs from its environment; tests replace it.
  struct Outside {
    /// Sends an event of SUBSCRIB on the network.
    std::function<void(const std::string& network, Octets event)> send;
    /// Sends a request and returns its id; 0: there is no daemon now.
    std::function<std::uint64_t(control::SubscribeRequest)> ask;
    std::function<void(control::RefusalRequest)> report;
    std::function<void(const std::string&)> log;
    std::function<std::uint32_t()> random;
  };
  explicit Subscriptions(Outside outside) : outside_(std::move(outside)) {}

  /// Takes the daemon's present list: from which networks subscriptions are accepted, and what to
  /// subscribe to.
  void set(const control::Subscriptions& said, std::uint64_t now);
  /// Takes a message from a network. `source`: the sender as text.
  void receive(const std::string& network, const std::string& source, Octets event,
               std::uint64_t now);
  /// Takes the daemon's reply to a request of Outside::ask.
  void answered(std::uint64_t request, const control::Reply& reply, std::uint64_t now);
  /// To be called when something was decided about the subject: the answers to its peers may be
  /// outdated.
  void decided(std::uint64_t subject);
  /// To be called when the daemon is connected again or has decided everything again.
  void ask_all();
  /// To be called when the connection is lost: pending requests will not be answered.
  void daemon_gone() { asked_.clear(); }
  /// Does what is due: renewals, expired leases, requests to the daemon.
  void turn(std::uint64_t now);

  [[nodiscard]] std::size_t peers() const { return peers_.size(); }
  [[nodiscard]] std::size_t own() const { return own_.size(); }

 private:
  /// Identifies the subscription of a peer: the sender on a network, and the subject.
  struct PeerKey {
    std::string network;
    std::uint64_t subject = 0;
    std::string source;
    auto operator<=>(const PeerKey&) const = default;
  };
  enum class Verdict : std::uint8_t { unknown, granted, refused };
  /// The subscription of a peer.
  struct Peer {
    Subscription wanted;
    std::optional<std::uint64_t> ends_at{};  ///< nullopt: without limit
    Verdict verdict = Verdict::unknown;      ///< decision of the daemon
    std::string reason{};                    ///< reason of its refusal
    bool admitted = false;  ///< it was granted and not ended since, so the daemon has the
                            ///< subscription
    bool to_ask = false;
    std::uint64_t joined = 0;  ///< position in the order in which peers were granted
    bool proven = false;  ///< its requirement was passed on together with the others, and granted
                          ///< further on
    std::uint64_t not_before = 0;  ///< after a refusal, the earliest time to ask the daemon again
    bool to_answer = false;        ///< it expects an answer, even if that is the same as before
    std::optional<std::string> answered{};  ///< the last answer; empty: granted, otherwise the
                                            ///< reason of the refusal
  };
  /// Identifies an own subscription: the subject, and the network on which it is sent.
  struct OwnKey {
    std::uint64_t subject = 0;
    std::string network;
    auto operator<=>(const OwnKey&) const = default;
  };
  /// Answer of a gateway further on.
  struct Answer {
    std::optional<std::string> refused{};
    std::uint64_t at = 0;
  };
  /// An own subscription.
  struct Own {
    Subscription message;
    bool begins_here = false;  ///< it is also for subscribers on this gateway, not only for peers
    std::uint64_t due_at = 0;
    bool was_sent = false;
    std::map<std::string, Answer> answers{};  ///< answers to the present message, by their senders
    std::optional<std::string> refused{};     ///< which gateway refuses and why; set if no gateway
                                              ///< grants it
    std::uint64_t refused_at = 0;             ///< when the refusal was confirmed last
    bool is_of_message = false;               ///< the refusal is of the present requirement
    /// Gives the message a new number, because its requirement or its subscribers have changed
    /// since it was answered.
    void renumber() {
      ++message.number;
      answers.clear();
      is_of_message = false;
    }
  };
  /// An own subscription that the daemon wants.
  struct Wanted {
    AttributeSet required;
    bool begins_here = false;
  };
  using AllWanted = std::map<OwnKey, Wanted>;
  /// A pending request to the daemon about the subscription of a peer.
  struct PendingSubscription {
    PeerKey peer;
    AttributeSet required;
    bool end = false;
  };

  void set_networks(const control::Subscriptions& said);
  [[nodiscard]] AllWanted wanted_of(const control::Subscriptions& said) const;
  void end_all_but(const AllWanted& wanted);
  void subscribe(PeerKey key, const Subscription& message, std::uint64_t now);
  void end(const PeerKey& key);
  void on_answer(const std::string& network, const std::string& source, const Subscription& message,
                 std::uint64_t now);
  void judge(const OwnKey& key, Own& own, std::uint64_t now);
  /// The granted peers that an own subscription is for.
  [[nodiscard]] std::vector<std::pair<const PeerKey*, Peer*>> behind(const OwnKey& key);
  /// Refuses a single peer when the requirement of several is refused, so that the others are
  /// served. Returns false if no peer is more likely to be the cause than others.
  bool refuse_one(const OwnKey& key, Own& own, const std::string& why, std::uint64_t now);
  void make_room_for(const PeerKey& newcomer, std::uint64_t now);
  void put_back(const PeerKey& key, Peer& peer, const std::string& why, std::uint64_t now);
  /// Whether a request to end a subscription of the subject is pending at the daemon.
  [[nodiscard]] bool is_ending(std::uint64_t subject) const;
  /// Returns false if the daemon could not be asked now.
  bool ask(const PeerKey& key, const Subscription& wanted, bool end);
  void answer(const PeerKey& key, Peer& peer);
  void answer_all();
  void send_own(const OwnKey& key, Own& own, std::uint64_t now);
  void send(const std::string& network, const Subscription& message);
  [[nodiscard]] std::size_t longest_on(const std::string& network) const;
  [[nodiscard]] std::uint8_t hops_left(const OwnKey& key, const Own& own) const;
  /// Why the peer gets no events although the daemon grants them: a gateway further on refuses, or
  /// too many gateways are on the way. Nullopt otherwise.
  [[nodiscard]] std::optional<std::string> refused_further_on(const PeerKey& key,
                                                              const Peer& peer) const;
  [[nodiscard]] std::size_t peers_on(const std::string& network) const;

  Outside outside_;
  std::map<std::string, control::SubscriptionNetwork> networks_;
  std::map<PeerKey, Peer> peers_;
  std::map<OwnKey, Own> own_;
  std::map<std::uint64_t, PendingSubscription> asked_;  ///< by request id
  std::uint64_t joined_ = 0;  ///< number of peers that were granted so far
  std::set<PeerKey> to_end_;  ///< peers whose subscriptions the daemon still has to end
};

}  // namespace mlcca::relay
