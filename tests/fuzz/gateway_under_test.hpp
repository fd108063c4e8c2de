// SPDX-License-Identifier: BSD-2-Clause
// The gateway of mlccad with its control server, event loop and journal, on gates of the real
// kernel in namespaces of its own; clients of three users; and what must hold of all of them at any
// time.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/handle.hpp"
#include "control/buffer.hpp"
#include "control/messages.hpp"
#include "core/admission/state.hpp"
#include "daemon/gates/readback.hpp"
#include "daemon/store/contents.hpp"
#include "tests/fuzz/surroundings.hpp"

namespace mlcca::fuzz {

/// A client, and what it must be answered. Its requests are read here as the server has to read
/// them.
struct Client {
  Fd socket;
  User user = User::root;
  bool reads = true;       ///< takes what comes
  bool is_shut = false;    ///< sends no more
  bool is_broken = false;  ///< has sent what is no request: an error follows, and the end
  bool monitors = false;
  control::Buffer sent;
  control::Buffer received;
  std::deque<control::Request> asked;  ///< and not answered yet
  std::string unsent;
};

class GatewayUnderTest {
 public:
  static constexpr std::size_t kMostClients = 6;

  /// Needs root.
  GatewayUnderTest();
  GatewayUnderTest(const GatewayUnderTest&) = delete;
  GatewayUnderTest(GatewayUnderTest&&) = delete;
  GatewayUnderTest& operator=(const GatewayUnderTest&) = delete;
  GatewayUnderTest& operator=(GatewayUnderTest&&) = delete;
  ~GatewayUnderTest();

  /// Back to the first description, with nothing admitted at run time and no client connected. It
  /// takes a fifth of a second to start, so that one serves many stories.
  void begin();
  /// Of the first admission since then.
  [[nodiscard]] std::uint64_t first_id() const { return first_id_; }

  /// What a client does; those that are not there do nothing.
  void connect(User user);
  void send(std::size_t client, std::string_view octets);
  void close(std::size_t client);
  void shut(std::size_t client);
  void set_reading(std::size_t client, bool reads);

  /// Another text in place of the description, which counts when it is read.
  void describe(std::size_t number);
  /// What the daemon does once a second.
  void run_round();
  /// It ends, in order or at once, and starts again. All clients are gone then.
  void restart(bool in_order);

  /// Until every client that reads is answered; then everything must hold. Gates are read back when
  /// the journal has changed, which takes most of the time.
  void settle();
  /// They are read back whatever the journal says.
  void finish();

 private:
  struct Parts;
  struct Alive {
    std::uint64_t subject = 0;
    std::string key;
    bool may_end = false;  ///< a lease, or a connection that holds it
  };
  void start();
  void ask(decltype(control::Request::body) body);
  void run_loop(std::uint64_t micros);
  bool exchange();
  void receive(Client& client);
  void take(Client& client, const control::Reply& reply);
  void judge(const Client& client, const control::Request& request, const control::Reply& reply);
  void judge_release(const control::ReleaseRequest& request);
  void lose(Client& client);
  [[nodiscard]] std::optional<std::uint64_t> subject_named(const std::string& name) const;
  [[nodiscard]] store::Contents stored() const;
  void check(bool gates_too = false);
  void check_admissions(const store::Contents& journal);
  void check_gates(const store::Contents& journal) const;
  void check_slot(const gates::SlotSpec& slot, const store::Contents& journal,
                  const std::string& where) const;
  void check_unlisted_slot(const gates::SlotSpec& slot, const store::Contents& journal,
                           const std::string& what) const;

  std::unique_ptr<Parts> parts_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::map<std::uint64_t, Alive> alive_;  ///< admissions that were answered, and not released since
  std::unique_ptr<core::State> names_;    ///< for the names of the description in force
  std::size_t written_ = 0;               ///< description that the next reload reads
  std::size_t in_force_ = 0;
  bool audit_ = false;
  bool unsure_ = false;  ///< a client has no answer about what was admitted or released
  store::Contents checked_;
  std::uint64_t first_id_ = 1;
  std::size_t memory_ = 0;  ///< at the beginning
};

}  // namespace mlcca::fuzz
