// SPDX-License-Identifier: BSD-2-Clause
// A daemon that answers what a test wants, on a socket in a directory of its own.
#pragma once
#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "base/handle.hpp"
#include "control/messages.hpp"

namespace mlcca::test {

/// A fresh directory, gone with its files at the end.
class TempDir {
 public:
  TempDir();
  ~TempDir();
  TempDir(const TempDir&) = delete;
  TempDir& operator=(const TempDir&) = delete;

  [[nodiscard]] std::string path(const std::string& name) const { return directory_ + "/" + name; }

 private:
  std::string directory_;
};

/// A listening socket at `path` whose connections are never accepted.
Fd listen_at(const std::string& path);

/// Serves one connection after the other in a thread of its own.
class Server {
 public:
  /// What follows a request. Replies of id 0 that are not events get the id of the request.
  struct Answer {
    std::vector<control::Reply> replies;
    bool hang_up = false;
  };
  using Handler = std::function<Answer(const control::Request&)>;

  explicit Server(Handler handler);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] std::string path() const { return directory_.path("control.sock"); }

  /// Lets it hang: it keeps its connections and answers nothing any more.
  void hang(bool hangs) {
    hangs_ = hangs;
    hangs_.notify_all();
  }

  /// Every request so far except pings, without the flag for slices.
  [[nodiscard]] std::vector<control::Request> requests();

 private:
  void serve(int connection);
  void run();

  TempDir directory_;
  Fd listener_;
  Handler handler_;
  std::atomic<bool> hangs_ = false;
  std::mutex mutex_;
  std::vector<control::Request> requests_;
  std::thread thread_;
};

}  // namespace mlcca::test
