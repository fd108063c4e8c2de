// SPDX-License-Identifier: BSD-2-Clause
// Collects texts that clients hand over in parts, one per session. An upload that never ends blocks
// nobody: it ends after kLongest, and makes room if there are too many.
#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace mlcca {

class Uploads {
 public:
  /// The most uploads at once. For a further one, the oldest one of the user with the most uploads
  /// is given up.
  static constexpr std::size_t kMost = 4;
  /// ns from the first part on.
  static constexpr std::uint64_t kLongest = 60'000'000'000;

  /// `most`: the most bytes of one text.
  Uploads(const Clock& clock, std::size_t most) : clock_(clock), most_(most) {}

  /// Adds a part. Returns the number of bytes so far; the error says why the upload was given up.
  Result<std::size_t> add(std::uint64_t session, uid_t user, std::string_view part);
  /// Adds the last part and returns the text. The session has no upload any more.
  Result<std::string> finish(std::uint64_t session, uid_t user, std::string_view part);
  void end(std::uint64_t session) { all_.erase(session); }
  /// To be called once a second.
  void poll();

 private:
  struct Upload {
    uid_t user = 0;
    std::uint64_t begun = 0;
    std::string text;
    std::string given_up;  ///< why, until its client is answered; empty: it continues
  };

  static void give_up(Upload& upload, std::string why);
  void make_room();

  const Clock& clock_;
  std::size_t most_;
  std::map<std::uint64_t, Upload> all_;  ///< by session
};

}  // namespace mlcca
