// SPDX-License-Identifier: BSD-2-Clause
// Plays random histories, each from a seed of its own, shared among a process for each CPU.
#pragma once
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

namespace mlcca::test {

inline std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
  const char* const text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// The result is what went wrong in the history of that seed; empty: nothing.
using History = std::function<std::string(std::uint64_t seed)>;

/// Plays every `step`th history from `first` on, below `end`. The result is how many went wrong;
/// it stops after the third one.
inline std::uint64_t play(const History& history, std::uint64_t first, std::uint64_t end,
                          std::uint64_t step) {
  constexpr std::uint64_t most_bad = 3;
  std::uint64_t bad = 0;
  for (std::uint64_t seed = first; seed < end && bad < most_bad; seed += step) {
    const std::string wrong = history(seed);
    if (wrong.empty()) continue;
    ++bad;
    std::fprintf(stderr, "%s\n  again: SETS=1 SEED=%llu\n", wrong.c_str(),
                 static_cast<unsigned long long>(seed));
  }
  return bad;
}

/// Plays SETS histories (`sets`, unless the environment says otherwise) from the seed SEED on. Each
/// process adds what it counts to `tally`; the sum of all is in it afterwards. Returns the number
/// of histories.
template <class Tally>
std::uint64_t play_histories(std::uint64_t sets, Tally& tally, const History& history) {
  sets = from_environment("SETS", sets);
  const std::uint64_t first = from_environment("SEED", 1);
  const auto cpus = static_cast<std::uint64_t>(::sysconf(_SC_NPROCESSORS_ONLN));
  const std::uint64_t shares = std::clamp<std::uint64_t>(cpus, 1, sets);
  std::array<int, 2> counted{};
  if (::pipe(counted.data()) != 0) {
    ADD_FAILURE() << "there is no pipe";
    return 0;
  }
  std::vector<pid_t> children;
  for (std::uint64_t share = 0; share < shares; ++share) {
    const pid_t child = ::fork();
    if (child == 0) {
      const std::uint64_t bad = play(history, first + share, first + sets, shares);
      const bool written = ::write(counted[1], &tally, sizeof tally) == sizeof tally;
      ::_exit(bad != 0 || !written ? 1 : 0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = -1;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0) << "a history went wrong, or its process";
    Tally of_share;
    if (status == 0) {
      EXPECT_EQ(::read(counted[0], &of_share, sizeof of_share),
                static_cast<ssize_t>(sizeof of_share));
      tally += of_share;
    }
  }
  ::close(counted[0]);
  ::close(counted[1]);
  return sets;
}

}  // namespace mlcca::test
