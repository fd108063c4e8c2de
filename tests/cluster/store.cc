// SPDX-License-Identifier: BSD-2-Clause
#include "tests/cluster/store.hpp"

#include <csignal>
#include <sstream>

#include "tests/support/require.hpp"

namespace mlcca::test {

void make_certificates(const WorkFolder& folder) {
  const bool made = run_script(R"(
authority() {
	openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout $1.key \
		-out $1.pem -subj /CN=$1 -days 2
}
certificate() { # NAME AUTHORITY USAGE
	openssl req -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout $1.key -out $1.csr -subj /CN=${1%-*}
	printf 'subjectAltName=IP:127.0.0.1,DNS:localhost\nextendedKeyUsage=%s\n' $3 >$1.ext
	openssl x509 -req -in $1.csr -CA $2.pem -CAkey $2.key -CAcreateserial -out $1.pem -days 2 -extfile $1.ext
}
authority ca
authority other
certificate server ca serverAuth,clientAuth
for user in root gw1 gw2; do certificate $user ca clientAuth; done
certificate gw1-other other clientAuth
)",
                               folder.path());
  require(made, "certificates");
}

Store::Store(const WorkFolder& folder, std::size_t members, std::vector<std::string> options)
    : folder_(folder), options_(std::move(options)), members_(members) {
  for (std::size_t i = 0; i < members; ++i) {
    members_[i].name = "m" + std::to_string(i);
    members_[i].data = folder_ / members_[i].name;
    members_[i].port = free_port();
    members_[i].peer_port = free_port();
  }
  for (std::size_t i = 0; i < members; ++i) start(i);
  std::string script = "user add root --no-password\nuser grant-role root root\n";
  for (const std::string user : {"gw1", "gw2"}) {
    script +=
        "role add " + user + "\nrole grant-permission " + user + " --prefix=true read /mlcca/t/\n";
    for (const std::string& own :
         {"r/" + user + "/", "r/lan/" + user + "/", "m/" + user, "a/" + user + "/",
          std::string("d/"), std::string("f/"), std::string("v/"), std::string("x/")})
      script += "role grant-permission " + user + " --prefix=true readwrite /mlcca/t/" + own + '\n';
    script += "user add " + user + " --no-password\nuser grant-role " + user + ' ' + user + '\n';
  }
  std::istringstream lines(script + "auth enable\n");
  std::string all;
  for (std::string line; std::getline(lines, line);)
    all += (all.empty() ? "" : " && etcdctl $ROOT ") + line;
  require(control(all), "users and roles of the store");
}

std::string Store::endpoint(std::size_t member) const {
  return "https://127.0.0.1:" + std::to_string(members_[member].port);
}

std::string Store::peer() const {
  return "http://127.0.0.1:" + std::to_string(members_[0].peer_port);
}

void Store::start(std::size_t member) {
  Member& one = members_[member];
  std::string all;
  for (const Member& other : members_)
    all += (all.empty() ? "" : ",") + other.name +
           "=http://127.0.0.1:" + std::to_string(other.peer_port);
  const std::string peer = "http://127.0.0.1:" + std::to_string(one.peer_port);
  std::vector<std::string> command{"etcd",
                                   "--name",
                                   one.name,
                                   "--data-dir",
                                   one.data,
                                   "--listen-client-urls",
                                   endpoint(member),
                                   "--advertise-client-urls",
                                   endpoint(member),
                                   "--listen-peer-urls",
                                   peer,
                                   "--initial-advertise-peer-urls",
                                   peer,
                                   "--initial-cluster",
                                   all,
                                   "--cert-file",
                                   folder_ / "server.pem",
                                   "--key-file",
                                   folder_ / "server.key",
                                   "--client-cert-auth",
                                   "--trusted-ca-file",
                                   folder_ / "ca.pem",
                                   "--bcrypt-cost",
                                   "4",
                                   "--logger",
                                   "zap",
                                   "--log-level",
                                   "error"};
  command.insert(command.end(), options_.begin(), options_.end());
  one.program = Program(command, folder_ / (one.name + ".log"));
}

void Store::pause(std::size_t member) { members_[member].program.signal(SIGSTOP); }
void Store::resume(std::size_t member) { members_[member].program.signal(SIGCONT); }

bool Store::control(const std::string& command) const {
  std::string endpoints;
  for (std::size_t i = 0; i < count(); ++i) endpoints += (i == 0 ? "" : ",") + endpoint(i);
  return run_script(
      "export ETCDCTL_API=3\nROOT='--cacert=ca.pem --cert=root.pem --key=root.key"
      " --dial-timeout=60s --command-timeout=60s --endpoints=" +
          endpoints + "'\netcdctl $ROOT " + command,
      folder_.path());
}

std::size_t Store::leader() const {
  for (;;) {
    const std::string out = folder_ / "status";
    if (control("endpoint status >" + out)) {
      std::istringstream lines(text_of_file(out));
      std::string line;
      // "ENDPOINT, ID, VERSION, SIZE, IS LEADER, …"
      for (std::size_t i = 0; i < count() && std::getline(lines, line); ++i)
        if (line.find(", true, false,") != std::string::npos) return i;
    }
  }
}

}  // namespace mlcca::test
