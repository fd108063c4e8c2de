// SPDX-License-Identifier: BSD-2-Clause
// Texts that clients hand over in parts, each in its session. One that never ends blocks nobody:
// it ends after a while, and gives way where there are too many.
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
  /// At once. For one more the oldest goes, of the user who has most of them.
  static constexpr std::size_t kMost = 4;
  /// From the first part on, ns.
  static constexpr std::uint64_t kLongest = 60'000'000'000;

  /// `most`: bytes of one.
  Uploads(const Clock& clock, std::size_t most) : clock_(clock), most_(most) {}

  /// How many bytes there are now; the error says why there are none any more.
  Result<std::size_t> add(std::uint64_t session, uid_t user, std::string_view part);
  /// With the last part; the session has none any more.
  Result<std::string> finish(std::uint64_t session, uid_t user, std::string_view part);
  void end(std::uint64_t session) { all_.erase(session); }
  /// Once a second.
  void poll();

 private:
  struct Upload {
    uid_t user = 0;
    std::uint64_t begun = 0;
    std::string text;
    std::string given_up;  ///< why, until its client is answered; empty: it goes on
  };

  static void give_up(Upload& upload, std::string why);
  void make_room();

  const Clock& clock_;
  std::size_t most_;
  std::map<std::uint64_t, Upload> all_;  ///< by session
};

}  // namespace mlcca
