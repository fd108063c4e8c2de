// SPDX-License-Identifier: BSD-2-Clause
// The answers of mlccad for one scrape.
#pragma once
#include <chrono>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/client.hpp"
#include "control/messages.hpp"

namespace mlcca::exporter {

/// Answers that mlccad makes at once in its event loop. An answer that failed is nullopt.
struct Live {
  std::optional<control::Status> status;
  std::optional<control::Channels> channels;
  std::optional<control::Cluster> cluster;
};

/// Answers for which mlccad forks a process: they take tens of ms, and their rate is limited
/// (docs/reference/limits.md).
struct Reports {
  std::optional<control::Networks> networks;
  std::optional<control::Reservations> reservations;
  std::optional<control::Gates> gates;
  std::optional<control::Routes> routes;
  std::optional<control::ClusterMembers> members;
};

/// A request that failed.
struct Failure {
  std::string request;  ///< name of the request ("status"); "connect" if the daemon was not reached
  std::string why;
};

/// The answers that a page shows; `reports` are `reports_age_s` seconds old.
struct Answers {
  Live live;
  Reports reports;
  double reports_age_s = 0;
};

/// A connection to the control socket for one scrape. After an error of the connection no further
/// request is sent; a request that the daemon refuses is one failure among answers.
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
  std::optional<control::Client> client_;  ///< empty after an error of the connection
  std::vector<Failure> failures_;
};

}  // namespace mlcca::exporter
