// SPDX-License-Identifier: BSD-2-Clause
// A real etcd on the loopback: TLS, client certificates and roles.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "tests/cluster/processes.hpp"

namespace mlcca::test {

/// Keys and certificates in a folder: NAME.pem and NAME.key, by ca.pem.
void make_certificates(const WorkFolder& folder);

class Store {
 public:
  /// So many members. gw1 and gw2 read /mlcca/t/ and write what is below /mlcca/t/r/gw1/ (gw2/),
  /// /mlcca/t/v/ and /mlcca/t/x/, and what a gateway
  /// on the network lan writes; `root` may do everything.
  Store(const WorkFolder& folder, std::size_t members, std::vector<std::string> options = {});

  [[nodiscard]] std::size_t count() const { return members_.size(); }
  [[nodiscard]] std::string endpoint(std::size_t member) const;
  [[nodiscard]] int port(std::size_t member) const { return members_[member].port; }
  [[nodiscard]] pid_t pid(std::size_t member) const { return members_[member].program.pid(); }
  void start(std::size_t member);
  void kill(std::size_t member) { members_[member].program.end(); }
  void pause(std::size_t member);
  void resume(std::size_t member);
  /// Of root: what is behind `etcdctl`. False: it failed.
  [[nodiscard]] bool control(const std::string& command) const;
  /// Which member leads.
  [[nodiscard]] std::size_t leader() const;
  /// Takes another data folder for the only member, which does not run.
  void set_data(const std::string& folder) { members_[0].data = folder; }
  [[nodiscard]] std::string peer() const;  ///< of the only member

 private:
  struct Member {
    std::string name, data;
    int port = 0, peer_port = 0;
    Program program;
  };
  const WorkFolder& folder_;
  std::vector<std::string> options_;
  std::vector<Member> members_;
};

}  // namespace mlcca::test
