// SPDX-License-Identifier: BSD-2-Clause
// Recordings of traffic: whatever is in a file, what is drafted from it is a description.
#include <cstddef>
#include <cstdint>
#include <span>

#include "description/read.hpp"
#include "tests/fuzz/demand.hpp"
#include "tools/learn/draft.hpp"
#include "tools/learn/observer.hpp"
#include "tools/learn/recording.hpp"

namespace mlcca {
namespace {

void learn_from(std::span<const std::uint8_t> bytes) {
  learn::Interfaces interfaces;
  learn::Observer observer;
  static_cast<void>(learn::read_recording(bytes, "recording", interfaces,
                                          [&](const learn::Frame& f) { observer.add(f); }));
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
