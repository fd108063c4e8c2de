// SPDX-License-Identifier: BSD-2-Clause
// Fuzzes recordings of traffic. Whatever a file has, compressed or not, the draft from it must be a
// valid description, and reading it in pieces must give the same frames.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "description/read.hpp"
#include "tests/fuzz/demand.hpp"
#include "tools/learn/draft.hpp"
#include "tools/learn/input.hpp"
#include "tools/learn/observer.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca {
namespace {

/// Reads a recording as from a pipe that gives few bytes at once.
std::uint64_t frames_in_pieces(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t piece = 61;
  learn::Interfaces interfaces;
  std::uint64_t frames = 0;
  learn::Input input([&](std::span<std::uint8_t> to) -> Result<std::size_t> {
    const std::size_t size = std::min({piece, to.size(), bytes.size()});
    std::ranges::copy(bytes.first(size), to.begin());
    bytes = bytes.subspan(size);
    return size;
  });
  static_cast<void>(learn::read_recording(input, "recording", interfaces,
                                          [&](const learn::Frame&) { ++frames; }));
  return frames;
}

void learn_from(std::span<const std::uint8_t> bytes) {
  learn::Interfaces interfaces;
  learn::Observer observer;
  std::uint64_t frames = 0;
  static_cast<void>(
      learn::read_recording(bytes, "recording", interfaces, [&](const learn::Frame& f) {
        ++frames;
        observer.add(f);
      }));
  const std::uint64_t in_pieces = frames_in_pieces(bytes);
  fuzz::demand(frames == in_pieces,
               std::to_string(frames) + " frames, and in pieces " + std::to_string(in_pieces));
  observer.finish(interfaces.names().size(), interfaces.media());
  const learn::Draft draft = learn::draft_of(observer, interfaces.names(), {});
  const auto system = description::read_memory(draft.xml, "draft.xml", {}, description::Users::any);
  fuzz::demand(system.has_value(), draft.xml);
}

}  // namespace
}  // namespace mlcca

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  mlcca::learn_from({data, size});
  return 0;
}
