// SPDX-License-Identifier: BSD-2-Clause
// Any octets as messages between mlccad and mlcca-cluster. The first octet says who sends them;
// each message has its length in two octets in front. What is understood is written again, and read
// as the same.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include "daemon/cluster/wire.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace mlcca;
using namespace mlcca::cluster;
using fuzz::demand;

std::vector<wire::Message> written(const wire::ToStore& what) {
  if (const auto* txn = std::get_if<core::cluster::Txn>(&what)) {
    demand(wire::misfit_of(*txn).empty(), "a transaction that does not fit");
    return wire::messages_of(*txn);
  }
  if (const auto* hello = std::get_if<wire::Hello>(&what)) return {wire::message_of(*hello)};
  if (const auto* follow = std::get_if<wire::Follow>(&what)) return {wire::message_of(*follow)};
  return {wire::message_of(std::get<wire::Credit>(what))};
}

std::vector<wire::Message> written(const ClusterMessage& what) {
  if (const auto* batch = std::get_if<core::cluster::Batch>(&what)) {
    demand(batch->entries.size() <= wire::kMaxBatch, "too many entries");
    std::vector<wire::Message> out;
    std::size_t next = 0;
    do out.push_back(wire::message_of(*batch, next, wire::kMaxBatch, false));
    while (next < batch->entries.size());
    return out;
  }
  if (const auto* result = std::get_if<core::cluster::TxnResult>(&what)) {
    demand(result->read.size() <= wire::kMaxOperations, "too much is read");
    return wire::messages_of(*result);
  }
  if (const auto* state = std::get_if<core::cluster::StoreState>(&what))
    return {wire::message_of(*state)};
  if (const auto* snapshot = std::get_if<ClusterSnapshot>(&what))
    return {wire::message_of(*snapshot)};
  return {wire::message_of(std::get<ClusterSynced>(what))};
}

std::optional<wire::ToStore> whole(std::optional<wire::ToStore> read) { return read; }
std::optional<ClusterMessage> whole(wire::ReaderOfStore::Read read) {
  return std::move(read.whole);
}

template <class Reader>
void play(std::span<const char> rest) {
  Reader reader;
  while (rest.size() >= 2) {
    const auto stated = static_cast<std::size_t>(static_cast<unsigned char>(rest[0])) |
                        static_cast<std::size_t>(static_cast<unsigned char>(rest[1])) << 8U;
    const std::size_t length = std::min(stated, rest.size() - 2);
    auto taken = reader.take(rest.subspan(2, length));
    if (!taken) return;  // and nothing more is taken from there
    rest = rest.subspan(2 + length);
    const auto read = whole(std::move(*taken));
    if (!read) continue;
    const auto first = written(*read);
    Reader again;
    std::size_t left = first.size();
    for (const auto& message : first) {
      demand(message.size() <= wire::kMaxMessage, "a message that is too long");
      auto same_taken = again.take(message);
      demand(same_taken.has_value(), "it is not understood any more");
      const auto same = whole(std::move(*same_taken));
      demand(same.has_value() == (--left == 0), "another number of messages");
      if (same) demand(written(*same) == first, "another message");
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const char> rest(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] == 'g')
    play<wire::ReaderOfGateway>(rest);
  else
    play<wire::ReaderOfStore>(rest);
  return 0;
}
