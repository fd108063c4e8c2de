// SPDX-License-Identifier: BSD-2-Clause
// The rollout of one description to all gateways of a cluster: what this gateway proposes, judges
// and puts in force. The protocol is in core/cluster/rollout; docs/explanation/cluster.md says what
// follows from it.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "control/messages.hpp"
#include "core/cluster/following.hpp"
#include "core/cluster/member.hpp"
#include "daemon/gateway/described.hpp"
#include "daemon/gateway/event_log.hpp"
#include "daemon/gateway/patience.hpp"
#include "daemon/gateway/requests/response.hpp"
#include "daemon/gateway/scene.hpp"
#include "daemon/gateway/uploads.hpp"
#include "daemon/outside/background.hpp"
#include "daemon/outside/description_texts.hpp"
#include "daemon/store/messages.hpp"
#include "description/bundle.hpp"

namespace mlcca {

/// Like ReadDescription, but reads a description from one text (description/bundle.hpp).
using ReadText = std::function<DescribedResult(const std::string& text)>;

/// This gateway's side of a rollout. It checks texts beside the loop, keeps those that it has voted
/// for on disk, follows the description that the cluster has in force, and keeps the file of the
/// operator apart from what a rollout has loaded.
class Rollout {
 public:
  using Digest = core::cluster::Digest;

  /// All references must outlive this object.
  struct Parts {
    Scene& scene;
    EventLog& log;
    Background& reading;
    DescriptionTexts& texts;
    Patience& patience;
    const Clock& clock;
    ReadText read;
    /// Why a description cannot be used here with what is admitted; empty if it can.
    std::function<std::string(Described&)> misfit;
    /// What is granted here now and would be refused with that description, for which misfit() has
    /// been called: one line each.
    std::function<std::vector<std::string>(Described&)> losses;
    /// Puts another description in force, as a reload does. False if that is not possible now.
    /// `done` gets why it is not in force; empty if it is.
    std::function<bool(ReadDescription, std::function<void(const std::string&)> done)> load;
    /// Loads the file again, as an operator's reload does.
    std::function<bool(std::function<void(const std::string&)> done)> reload;
    /// Called when there is something for step().
    std::function<void()> wake;
  };
  explicit Rollout(Parts parts) : parts_(std::move(parts)) {}

  /// Takes from the journal what a gateway remembers of rollouts over a restart.
  void restore(const store::Membership& record);
  void put_into(store::Membership& record) const;

  /// Returns a function that reads the file by `read`, or instead what a rollout has put in force
  /// since the file was written. `member` provides texts of the store for those that are damaged
  /// here; nullptr at a start, when the store is not known yet.
  [[nodiscard]] ReadDescription reader(ReadDescription read,
                                       const core::cluster::Member* member) const;
  /// The scene has another description, which the kernel may still refuse.
  void loaded();
  /// The digest that was proposed to the former member of the protocol, if its outcome is not known
  /// yet.
  [[nodiscard]] std::optional<Digest> pending() const;

  // Events of the store.

  void on(const core::cluster::Judge& event);
  void on(const core::cluster::NotRolledOut& event);
  void on(const core::cluster::Switch& event);
  /// The description in force here, with its text: it is proposed as the first one of a cluster.
  [[nodiscard]] core::cluster::Rollout own();
  /// Does what is due. True if anything was done.
  bool step(core::cluster::Member& member);
  /// To be called once a second.
  void poll();
  void session_closed(std::uint64_t session);

  // Requests of clients.

  /// Takes a part of a text, or its last part with what is to be done with it.
  Response take(const Asker& asker, const control::RolloutRequest& request,
                core::cluster::Member& member);
  [[nodiscard]] control::Rollout state(const core::cluster::Member& member) const;

 private:
  enum class Why : std::uint8_t { judge, propose, follow };
  using Text = std::shared_ptr<const std::string>;
  /// A text that is read beside the loop, on a thread.
  struct Check {
    Why why = Why::judge;
    Digest digest{};  ///< the digest that it must have; none for a proposal
    Text text;        ///< null for a description to follow that is not in the store
    std::string damage = {};
    std::optional<DescribedResult> read = {};
    bool force = false;  ///< losses are no reason against it
  };
  /// The latest text that was found usable together with what is in force here; at most 8 MiB.
  struct Checked {
    Digest digest{};
    Text text;
    bool force = false;  ///< losses did not count
  };
  /// A description that cannot be put in force here, with the reason.
  struct Cannot {
    Digest digest{};
    std::string why;
  };
  /// The latest rollout that was begun here.
  struct Own {
    std::uint64_t number = 0;
    Digest digest{};
    std::string state, why;
    std::vector<std::string> without;
    std::optional<control::Actor> actor;
    bool force = false;
  };

  [[nodiscard]] std::string why_not(Check& check) const;
  [[nodiscard]] std::string why_lost(Described& next) const;
  [[nodiscard]] std::string unknown_gateway(const Described& next) const;
  void checked(Check& check);
  void lack(const Digest& digest);
  void end(const Check& check, const std::string& why);
  bool begin_check();
  bool give_up_check();
  bool cast_vote(core::cluster::Member& member);
  bool report_cannot(core::cluster::Member& member);
  bool stage(core::cluster::Member& member);
  bool follow(const core::cluster::Member& member);
  bool load();
  bool check_file(const core::cluster::Member& member);
  void note_followed();
  void finish(const std::string& why);
  void keep_needed();
  [[nodiscard]] std::string why_not_kept(const core::cluster::Judge& event);
  [[nodiscard]] std::optional<std::string> kept(const Digest& digest);
  [[nodiscard]] static Text in_store(const Digest& digest, const core::cluster::Member& member);
  void report_damage(const std::string& damage);
  Response begin(std::string text, const std::vector<std::string>& without, bool force,
                 const core::cluster::Member& member);
  Response cancel(core::cluster::Member& member);
  Response back(const control::RolloutRequest& request, const core::cluster::Member& member);
  Response accept(const core::cluster::Member& member);

  Parts parts_;
  core::cluster::Following following_;
  Digest former_{};  ///< the one before the description that the cluster has in force
  std::shared_ptr<Check> check_;
  bool check_begun_ = false;
  std::uint64_t check_since_ = 0;
  std::shared_ptr<Check> next_check_;  ///< begins when check_ has ended
  std::optional<std::pair<Digest, std::string>> vote_;
  std::optional<core::cluster::Rollout> staged_;
  std::optional<Digest> lacking_;  ///< a description whose text is neither here nor in the store
  std::optional<Cannot> cannot_;
  bool loading_ = false;
  bool busy_ = false;         ///< something could not begin; the next poll() retries it
  bool checks_file_ = false;  ///< the file was loaded unchecked, and is checked once
  std::optional<Checked> checked_;
  Own own_;
  Uploads uploads_{parts_.clock, description::kMaxBundle};
};

/// 64 hexadecimal digits; empty for a digest of zeros.
[[nodiscard]] std::string hex_of_digest(const Sha256::Digest& digest);
/// The leading digits that messages show.
[[nodiscard]] std::string shown_digits(const Sha256::Digest& digest);

}  // namespace mlcca
