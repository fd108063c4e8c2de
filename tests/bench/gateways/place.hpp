// SPDX-License-Identifier: BSD-2-Clause
// Where benches of several gateways run: namespaces of this process's own, and real gateways.
#pragma once
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "control/client.hpp"
#include "tests/cluster/processes.hpp"
#include "tests/cluster/store.hpp"

namespace mlcca::bench {

using Steady = std::chrono::steady_clock;

inline double ms_since(Steady::time_point start) {
  return std::chrono::duration<double, std::milli>(Steady::now() - start).count();
}

/// The user as whom mlcca-relay runs here.
inline constexpr const char* kRelayUser = "64990";

/// Networks and mounts of this process's own, of which nothing is left when it ends. Root.
void enter_place();
/// In a network namespace with a name.
void inside(const std::string& name, const std::function<void()>& work);
/// Octets that have passed the loopback, on which all talk to the store.
[[nodiscard]] std::uint64_t loopback_octets();
/// That a process has used of all processors, s.
[[nodiscard]] double processor_seconds(pid_t pid);
/// Resident, MiB.
[[nodiscard]] double resident_mib(pid_t pid);

/// "<Attribute>…" with a value of seconds and octets in the units that are stated.
[[nodiscard]] std::string ms_attribute(const std::string& name, double value);
[[nodiscard]] std::string octets_attribute(const std::string& name, std::uint64_t value);
/// An Ethernet on which events of FAMOUSO are.
[[nodiscard]] std::string ethernet(const std::string& name);

/// mlccad and mlcca-cluster of one gateway in the network namespace of its name; where it forwards,
/// mlcca-relay.
class RealGateway {
 public:
  struct Options {
    std::string name;
    std::string description;  ///< file
    std::string certificate;  ///< NAME.pem of make_certificates()
    std::string lease;
    std::string state;  ///< folder
  };
  RealGateway(const test::WorkFolder& folder, const test::Store& store, Options options);
  RealGateway(const RealGateway&) = delete;
  RealGateway& operator=(const RealGateway&) = delete;
  RealGateway(RealGateway&&) = delete;
  RealGateway& operator=(RealGateway&&) = delete;
  ~RealGateway();

  void start();
  void start_relay();
  /// As a machine that loses its power, but that its gates stay.
  void kill();
  void kill_daemon() { daemon_.end(); }
  void kill_relay() { relay_.end(); }
  /// What is reserved is given back first.
  void stop();
  [[nodiscard]] pid_t daemon() const { return daemon_.pid(); }
  [[nodiscard]] pid_t bridge() const { return bridge_.pid(); }

  [[nodiscard]] control::Client connect() const;
  /// How it stands in the cluster; an empty one: it does not answer.
  [[nodiscard]] control::Cluster standing() const;
  /// Waits until what is shared is open.
  void wait_until_in() const;
  [[nodiscard]] std::string log() const;

 private:
  [[nodiscard]] std::string file(const std::string& suffix) const {
    return folder_ / (options_.name + suffix);
  }
  const test::WorkFolder& folder_;
  Options options_;
  test::Program bridge_, daemon_, relay_;
};

/// Ends the bench, with what is known of why.
[[noreturn]] void give_up(const std::string& why);

/// Waits for something that a bench needs; ends the bench after a minute.
void wait_for(const std::string& what, const std::function<bool()>& holds);

}  // namespace mlcca::bench
