// SPDX-License-Identifier: BSD-2-Clause
// The gateway itself: events come in, the core decides, the kernel obeys, then the answer is given.
#pragma once
#include <cstdint>
#include <ctime>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/messages.hpp"
#include "core/result.hpp"
#include "core/state.hpp"
#include "daemon/drops.hpp"
#include "daemon/enforce/control.hpp"
#include "daemon/journal.hpp"
#include "daemon/net/links.hpp"
#include "daemon/options.hpp"
#include "daemon/ports.hpp"
#include "daemon/requests.hpp"
#include "daemon/serve/server.hpp"
#include "daemon/store/store.hpp"

namespace mlcca {

/// Why the daemon cannot start; what starting again cannot mend (a description or a store that
/// cannot be used) is told apart.
struct StartError {
  std::vector<std::string> lines;
  bool bad_input = false;
};

class Gateway {
 public:
  using Publish = std::function<void(const control::Event&)>;

  Gateway(Options options, Journal journal, enforce::Control control, net::Links links,
          net::FactsOf facts_of);
  Gateway(const Gateway&) = delete;
  Gateway& operator=(const Gateway&) = delete;
  Gateway(Gateway&&) = delete;
  Gateway& operator=(Gateway&&) = delete;
  ~Gateway() = default;

  /// Reads the description and what was admitted before, closes or keeps the gates accordingly and
  /// opens them. On failure every gate is closed.
  std::optional<StartError> start();
  /// Everything is denied; the gates stay in the kernel.
  void stop();
  /// As the control request does; what is wrong goes to the journal.
  void reload() { handle(control::ReloadRequest{}); }

  void on_event(Publish publish) { publish_ = std::move(publish); }
  control::Reply answer(const control::Request& request, const serve::Peer& peer);

  [[nodiscard]] int links_fd() const { return links_.fd(); }
  void links_changed();
  /// Udev learned something about an interface.
  void identities_changed() { follow_world(); }
  /// Sign of life for the kernel, at least every beat_interval().
  void beat();
  [[nodiscard]] std::uint64_t beat_interval() const { return control_.beat_interval(); }
  /// Once a second: lost filters, drops to report.
  void look_around();

  /// One line for systemd's status.
  [[nodiscard]] std::string summary() const;

 private:
  using Body = decltype(control::Reply::body);
  Body handle(const control::StatusRequest& request);
  Body handle(const control::NetworksRequest& request);
  Body handle(const control::ChannelsRequest& request);
  Body handle(const control::Query& request);
  Body handle(const control::Admit& request);
  Body handle(const control::ReleaseRequest& request);
  Body handle(const control::ExplainRequest& request);
  Body handle(const control::MonitorRequest& request);
  Body handle(const control::ModeRequest& request);
  Body handle(const control::ReloadRequest& request);

  struct Loaded {
    std::unique_ptr<core::State> state;
    std::size_t self = 0;
    std::vector<std::string> left_out;  ///< admissions that have no place in the description
  };
  using LoadResult = std::expected<Loaded, std::vector<std::string>>;
  [[nodiscard]] LoadResult load() const;
  void restore_into(Loaded& loaded) const;

  /// Follows the interfaces, decides anew and brings the kernel in line; reports what changed.
  void follow_world();
  Result<void> enforce();
  Result<void> settle();
  void open_unless_lost();
  void look_at_drops(bool mention);
  void tell(Note note);
  void tell_changes(const std::vector<std::vector<core::Verdict>>& before);
  void tell_verdict(Kind kind, const core::Verdict& verdict);
  /// "enforce" or "audit".
  [[nodiscard]] const char* mode_name() const;
  [[nodiscard]] Frames frames_of(const core::Verdict& verdict) const;
  [[nodiscard]] control::Channel report(const core::Verdict& verdict) const;
  [[nodiscard]] control::Channels report_known(const Asked& asked) const;
  Body admit_known(const Asked& asked);
  /// The newcomer's verdicts, or an error where there is nobody on the other side.
  [[nodiscard]] Body answer_to(const core::Proposal& proposal, const Asked& asked,
                               const char* to_do) const;

  Options options_;
  Journal journal_;
  enforce::Control control_;
  net::Links links_;
  Ports ports_;
  store::Store store_;
  store::Contents stored_;
  std::unique_ptr<core::State> state_;
  std::size_t self_ = 0;
  DropWatch drops_;
  Publish publish_;
  std::time_t started_ = 0;
  std::time_t loaded_ = 0;
  std::string last_error_;
};

}  // namespace mlcca
