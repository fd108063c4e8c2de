// SPDX-License-Identifier: BSD-2-Clause
// What a recording has, as it is read.
#pragma once
#include <string>
#include <vector>

#include "tests/tools/learn/traffic.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca::learn::test {

struct ReadBack {
  std::vector<Sent> sent;
  std::vector<std::string> names;
  Left left;
  std::string error;
};

/// `read` calls read_recording() with the interfaces and the function that takes frames.
template <class Read>
ReadBack read_back(const Read& read) {
  ReadBack out;
  Interfaces interfaces;
  const auto left = read(interfaces, [&](const Frame& f) {
    out.sent.push_back({f.ns, f.interface, f.id, {f.data.begin(), f.data.end()}, f.fd, f.local});
  });
  out.names = interfaces.names();
  if (left)
    out.left = *left;
  else
    out.error = left.error().text;
  return out;
}

}  // namespace mlcca::learn::test
