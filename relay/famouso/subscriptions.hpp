// SPDX-License-Identifier: BSD-2-Clause
// Subscriptions of a gateway: those of peers on its networks, which the daemon decides and which
// are answered, and its own, by which it passes on what they require to where the events come from.
// Bookkeeping only: messages, replies and time come in as arguments.
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

class Subscriptions {
 public:
  /// Between two messages of one own subscription, ns; its lease is three times that.
  static constexpr std::uint64_t kRenewal = 20'000'000'000;
  /// Of peers: what they state is taken for at least and at most so long, s.
  static constexpr std::uint16_t kShortestLease = 10;
  static constexpr std::uint16_t kLongestLease = 3'600;
  /// A refusal is repeated for so long without asking the daemon again, ns, whatever happens: a
  /// question in vain is itself reported as something that happened to the subject.
  static constexpr std::uint64_t kRefusalHolds = 10'000'000'000;
  /// Requests to the daemon that are not answered.
  static constexpr std::size_t kMostAsked = 64;
  /// Gateways on a way.
  static constexpr std::uint8_t kHops = 8;
  /// Gateways whose answers to one own subscription are kept.
  static constexpr std::size_t kMostAnswers = 16;

  struct Outside {
    /// On the network, as an event of SUBSCRIB.
    std::function<void(const std::string& network, Octets event)> send;
    /// The number of the request; 0: there is no daemon now.
    std::function<std::uint64_t(control::SubscribeRequest)> ask;
    std::function<void(control::RefusalRequest)> report;
    std::function<void(const std::string&)> log;
    std::function<std::uint32_t()> random;
  };
  explicit Subscriptions(Outside outside) : outside_(std::move(outside)) {}

  /// What the daemon says now: whom to take subscriptions from, and what to subscribe.
  void set(const control::Subscriptions& said, std::uint64_t now);
  /// A message has come. `source`: whoever sent it, as text.
  void receive(const std::string& network, const std::string& source, Octets event,
               std::uint64_t now);
  /// The daemon has answered a request of ask().
  void answered(std::uint64_t request, const control::Reply& reply, std::uint64_t now);
  /// Something was decided about the subject: what peers were answered may be wrong.
  void decided(std::uint64_t subject);
  /// There is a daemon again, or everything was decided again.
  void ask_all();
  /// Nothing that was asked is answered any more.
  void daemon_gone() { asked_.clear(); }
  /// What is due: renewals, leases that end, questions.
  void turn(std::uint64_t now);

  [[nodiscard]] std::size_t peers() const { return peers_.size(); }
  [[nodiscard]] std::size_t own() const { return own_.size(); }

 private:
  struct PeerKey {
    std::string network;
    std::uint64_t subject = 0;
    std::string source;
    auto operator<=>(const PeerKey&) const = default;
  };
  enum class Verdict : std::uint8_t { unknown, granted, refused };
  struct Peer {
    Subscription wanted;
    std::optional<std::uint64_t> ends_at{};  ///< nothing: never
    Verdict verdict = Verdict::unknown;      ///< of the daemon
    std::string reason{};                    ///< of its refusal
    bool admitted = false;                   ///< granted once, and not ended: the daemon has it
    bool to_ask = false;
    std::uint64_t joined = 0;               ///< when it was granted, in the order of all
    bool proven = false;                    ///< passed on with the others, and granted further on
    std::uint64_t not_before = 0;           ///< refused: when the daemon is asked again at first
    bool to_answer = false;                 ///< whatever it was answered before
    std::optional<std::string> answered{};  ///< empty: granted; else why refused
  };
  struct OwnKey {
    std::uint64_t subject = 0;
    std::string network;
    auto operator<=>(const OwnKey&) const = default;
  };
  /// Of a gateway further on.
  struct Answer {
    std::optional<std::string> refused{};
    std::uint64_t at = 0;
  };
  struct Own {
    Subscription message;
    bool begins_here = false;  ///< also for subscribers that are no peers
    std::uint64_t due_at = 0;
    bool was_sent = false;
    std::map<std::string, Answer> answers{};  ///< to this message, by who has sent them
    std::optional<std::string> refused{};     ///< by whom and why: nobody grants it
    std::uint64_t refused_at = 0;             ///< when that was said last
    bool is_of_message = false;               ///< refused as it is required now
    /// What it requires, or for whom, is not what was answered.
    void renumber() {
      ++message.number;
      answers.clear();
      is_of_message = false;
    }
  };
  /// What the daemon wants to be subscribed.
  struct Wanted {
    AttributeSet required;
    bool begins_here = false;
  };
  using AllWanted = std::map<OwnKey, Wanted>;
  struct Asked {
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
  /// Those whom an own subscription is for.
  [[nodiscard]] std::vector<std::pair<const PeerKey*, Peer*>> behind(const OwnKey& key);
  /// One of several asks for too much: it is refused alone. False: there is none of whom that is
  /// likelier than of others.
  bool refuse_one(const OwnKey& key, Own& own, const std::string& why, std::uint64_t now);
  void make_room_for(const PeerKey& newcomer, std::uint64_t now);
  void put_back(const PeerKey& key, Peer& peer, const std::string& why, std::uint64_t now);
  /// The daemon has not ended yet what no longer counts.
  [[nodiscard]] bool is_ending(std::uint64_t subject) const;
  /// False: it could not be asked now.
  bool ask(const PeerKey& key, const Subscription& wanted, bool end);
  void answer(const PeerKey& key, Peer& peer);
  void answer_all();
  void send_own(const OwnKey& key, Own& own, std::uint64_t now);
  void send(const std::string& network, const Subscription& message);
  [[nodiscard]] std::size_t longest_on(const std::string& network) const;
  [[nodiscard]] std::uint8_t hops_left(const OwnKey& key, const Own& own) const;
  /// Why its events do not come to it although the daemon grants that.
  [[nodiscard]] std::optional<std::string> refused_further_on(const PeerKey& key,
                                                              const Peer& peer) const;
  [[nodiscard]] std::size_t peers_on(const std::string& network) const;

  Outside outside_;
  std::map<std::string, control::SubscriptionNetwork> networks_;
  std::map<PeerKey, Peer> peers_;
  std::map<OwnKey, Own> own_;
  std::map<std::uint64_t, Asked> asked_;  ///< by the number of the request
  std::uint64_t joined_ = 0;              ///< peers that were granted something
  std::set<PeerKey> to_end_;              ///< the daemon has them still
};

}  // namespace mlcca::relay
