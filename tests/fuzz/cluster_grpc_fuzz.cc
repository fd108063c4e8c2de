// SPDX-License-Identifier: BSD-2-Clause
// Any octets as what a member of the store sends. The first octet says what: 'h' lines of headers,
// others frames, whose messages are taken for the answers of each call. The second octet is the
// size of the pieces that they come in.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "cluster/etcd.hpp"
#include "cluster/grpc.hpp"
#include "cluster/outcome.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using namespace mlcca::cluster;
using mlcca::core::cluster::Entry;
using mlcca::fuzz::demand;

constexpr std::size_t kMost = 1000;

void headers(std::string_view rest) {
  grpc::Trailers trailers;
  while (!rest.empty()) {
    const auto end = std::min(rest.find('\n'), rest.size());
    const bool taken = trailers.take(rest.substr(0, end));
    demand(taken == trailers.problem().empty(), "a problem without a word");
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (!taken) return;
  }
  demand(std::ranges::all_of(trailers.message(), [](char c) { return c >= ' ' && c <= '~'; }),
         "words that are not printable");
  (void)outcome_of({.status = trailers.status().value_or(End::kNoStatus),
                    .text = trailers.message(),
                    .sent = true});
}

void check(const std::vector<Entry>& entries) {
  for (const Entry& entry : entries)
    demand(!entry.key.empty() && entry.create >= 0 && entry.mod >= 0, "an entry that there is not");
}

void message(std::string_view octets) {
  if (const auto page = etcd::read_page(octets)) check(page->entries);
  if (const auto changes = etcd::read_changes(octets)) check(changes->entries);
  if (const auto txn = etcd::read_txn(octets, {"a", "b"})) {
    check(txn->read);
    demand(txn->succeeded || (txn->read.size() == 2 && txn->read[0].key == "a"),
           "another number of keys was read");
  }
  (void)etcd::read_status(octets);
}

void frames(std::size_t piece, std::string_view rest) {
  grpc::FrameReader reader(kMost);
  while (!rest.empty()) {
    const auto size = std::min(piece, rest.size());
    const bool right = reader.push(rest.substr(0, size));
    rest.remove_prefix(size);
    while (const auto next = reader.next()) {
      demand(next->size() <= kMost, "a message that is too long");
      message(*next);
    }
    if (!right) return;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::string_view rest(reinterpret_cast<const char*>(data) + 2, size - 2);
  if (data[0] == 'h')
    headers(rest);
  else
    frames(std::size_t{data[1]} + 1, rest);
  return 0;
}
