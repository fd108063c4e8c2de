// SPDX-License-Identifier: BSD-2-Clause
// One description for all gateways of a cluster: what this one proposes, judges and puts in force.
// The protocol is core/cluster/rollout's; docs/explanation/cluster.md says what follows from it.
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

/// Reads a description in one text (description/bundle.hpp). As ReadDescription.
using ReadText = std::function<DescribedResult(const std::string& text)>;

class Rollout {
 public:
  using Digest = core::cluster::Digest;

  /// All of them must outlive this.
  struct Parts {
    Scene& scene;
    EventLog& log;
    Background& reading;
    DescriptionTexts& texts;
    Patience& patience;
    const Clock& clock;
    ReadText read;
    /// Why a description cannot be used here, with what is admitted; empty: it can.
    std::function<std::string(Described&)> misfit;
    /// Puts another description in force as a reload does. False: not now. `done` gets why not;
    /// empty: it is.
    std::function<bool(ReadDescription, std::function<void(const std::string&)> done)> load;
    /// The file again, as an operator's reload does.
    std::function<bool(std::function<void(const std::string&)> done)> reload;
    /// There is something for step().
    std::function<void()> wake;
  };
  explicit Rollout(Parts parts) : parts_(std::move(parts)) {}

  /// What a gateway remembers of it over a restart.
  void restore(const store::Membership& record);
  void put_into(store::Membership& record) const;

  /// Reads the file by `read`, or in its place what a rollout has put in force since that was
  /// written. `member`: what the store has takes the place of what is damaged here; null: nobody
  /// knows that yet.
  [[nodiscard]] ReadDescription reader(ReadDescription read,
                                       const core::cluster::Member* member) const;
  /// The scene has another description, which may still be refused by the kernel.
  void loaded();
  /// Was handed to the member of the description before: what becomes of it is not known yet.
  [[nodiscard]] std::optional<Digest> pending() const;

  // What the store says.

  void on(const core::cluster::Judge& event);
  void on(const core::cluster::NotRolledOut& event);
  void on(const core::cluster::Switch& event);
  /// The first one of a cluster is proposed with its text.
  [[nodiscard]] core::cluster::Rollout own();
  /// Does what is due. True: something was asked for.
  bool step(core::cluster::Member& member);
  /// Once a second.
  void poll();
  void session_closed(std::uint64_t session);

  // Who wants something.

  /// A part of a text, or all of what is to be done with it.
  Response take(const Asker& asker, const control::RolloutRequest& request,
                const core::cluster::Member& member);
  [[nodiscard]] control::Rollout state(const core::cluster::Member& member) const;

 private:
  enum class Why : std::uint8_t { judge, propose, follow };
  using Text = std::shared_ptr<const std::string>;
  /// A text that is read beside the loop.
  struct Check {
    Why why = Why::judge;
    Digest digest{};  ///< that it must have; of what is proposed: none
    Text text;        ///< null: of what is followed, that is not in the store
    std::string damage = {};
    std::optional<DescribedResult> read = {};
  };
  /// The latest one that was found usable with what is in force here, 8 MiB at most.
  struct Checked {
    Digest digest{};
    Text text;
  };
  /// Why a description cannot be put in force here.
  struct Cannot {
    Digest digest{};
    std::string why;
  };
  /// The latest that was begun here.
  struct Own {
    std::uint64_t number = 0;
    Digest digest{};
    std::string state, why;
    std::vector<std::string> without;
    std::optional<control::Actor> actor;
  };

  [[nodiscard]] std::string why_not(Check& check) const;
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
  void follow(const core::cluster::Switch& event);
  void note_followed();
  void finish(const std::string& why);
  void keep_needed();
  [[nodiscard]] std::string why_not_kept(const core::cluster::Judge& event);
  [[nodiscard]] std::optional<std::string> kept(const Digest& digest);
  [[nodiscard]] static Text in_store(const Digest& digest, const core::cluster::Member& member);
  void report_damage(const std::string& damage);
  Response begin(std::string text, const std::vector<std::string>& without,
                 const core::cluster::Member& member);
  Response back(const control::RolloutRequest& request, const core::cluster::Member& member);
  Response accept(const core::cluster::Member& member);

  Parts parts_;
  Digest rolled_{}, replaced_{};  ///< that was put in force, in place of that file
  Digest in_force_{};             ///< the latest one that was, here as well
  Digest voted_{};
  Digest former_{};  ///< before the one that the cluster has in force
  std::shared_ptr<Check> check_;
  bool check_begun_ = false;
  std::uint64_t check_since_ = 0;
  std::shared_ptr<Check> next_check_;  ///< when that is over
  std::optional<std::pair<Digest, std::string>> vote_;
  std::optional<core::cluster::Rollout> staged_;
  std::optional<Digest> wanted_;   ///< that is to be in force here
  std::optional<Digest> lacking_;  ///< neither here nor in the store
  std::optional<Cannot> cannot_;
  bool loading_ = false;
  bool busy_ = false;         ///< something could not begin: at the next poll()
  bool checks_file_ = false;  ///< what was loaded without that can be checked, once
  std::optional<Checked> checked_;
  Own own_;
  Uploads uploads_{parts_.clock, description::kMaxBundle};
};

/// 64 hexadecimal digits; empty: none.
[[nodiscard]] std::string hex_of_digest(const Sha256::Digest& digest);
/// As many digits of it as messages show.
[[nodiscard]] std::string shown_digits(const Sha256::Digest& digest);

}  // namespace mlcca
