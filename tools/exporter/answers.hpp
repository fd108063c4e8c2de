// SPDX-License-Identifier: BSD-2-Clause
// What mlccad says at one moment.
#pragma once
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/client.hpp"
#include "control/messages.hpp"

namespace mlcca::exporter {

/// What mlccad makes in its loop at once. What could not be asked is not there.
struct Live {
  std::optional<control::Status> status;
  std::optional<control::Channels> channels;
  std::optional<control::Cluster> cluster;
};

/// What it makes beside its loop, for which it forks: tens of ms, and not as often as one likes
/// (docs/reference/limits.md).
struct Reports {
  std::optional<control::Networks> networks;
  std::optional<control::Reservations> reservations;
  std::optional<control::Gates> gates;
  std::optional<control::Routes> routes;
  std::optional<control::ClusterMembers> members;
};

struct Failure {
  std::string request;  ///< "status", …; "connect": no daemon was reached
  std::string why;
};

struct Answers {
  Live live;
  Reports reports;
  double reports_age_s = 0;
};

/// A connection to the control socket for one scrape. After it has failed nothing more is asked;
/// what the daemon refuses is one failure among answers.
class Asking {
 public:
  Asking(const std::string& path, std::chrono::milliseconds patience);
  [[nodiscard]] Live live();
  [[nodiscard]] Reports reports();
  [[nodiscard]] const std::vector<Failure>& failures() const { return failures_; }

 private:
  template <class Question, class Answer>
  void ask(const char* request, std::optional<Answer>& to, Question question = {});
  void failed(const char* request, std::string why) {
    failures_.push_back({request, std::move(why)});
  }
  std::optional<control::Client> client_;  ///< none: it has failed
  std::vector<Failure> failures_;
};

}  // namespace mlcca::exporter
