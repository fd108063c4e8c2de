// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/cluster/wire.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>
#include <utility>

#include "base/hash.hpp"
#include "base/number.hpp"
#include "base/octets.hpp"
#include "base/text.hpp"

namespace mlcca::cluster::wire {
namespace {

using core::cluster::Batch;
using core::cluster::Compare;
using core::cluster::Entry;
using core::cluster::Outcome;
using core::cluster::Put;
using core::cluster::StoreState;
using core::cluster::Txn;
using core::cluster::TxnResult;

enum class Kind : std::uint8_t {
  none = 0,
  hello = 1,
  follow = 2,
  txn = 3,
  credit = 4,
  state = 17,
  begin = 18,
  batch = 19,
  synced = 20,
  result = 21
};

constexpr std::size_t kValueLength = 4;                      // octets of the length of a value
constexpr std::size_t kRoom = kMaxMessage - kMaxWords - 64;  // for the list of a message
constexpr std::uint64_t kMilli = 1'000'000;                  // ns

OctetWriter begin(Kind kind) {
  OctetWriter out;
  out.number(static_cast<std::uint64_t>(kind), 1);
  return out;
}

void put_revision(OctetWriter& to, std::int64_t revision) {
  to.number(static_cast<std::uint64_t>(revision), 8);
}
/// A revision below 0 is of no store, and refused.
std::int64_t take_revision(OctetReader& from) {
  const auto revision = static_cast<std::int64_t>(from.number(8));
  if (revision < 0) from.refuse();
  return from.right() ? revision : 0;
}
void put_words(OctetWriter& to, const std::string& words) { to.text(cut(words, kMaxWords)); }
std::string take_key(OctetReader& from) {
  std::string key = from.text(kMaxKey);
  if (key.empty()) from.refuse();
  return key;
}

std::size_t size_of(const Entry& entry) { return entry.key.size() + entry.value.size(); }

void put_entry(OctetWriter& to, const Entry& entry) {
  to.text(entry.key);
  put_revision(to, entry.create);
  put_revision(to, entry.mod);
  to.number(entry.gone ? 1 : 0, 1);
  to.text(entry.value, kValueLength);
}
Entry take_entry(OctetReader& from) {
  Entry entry;
  entry.key = take_key(from);
  entry.create = take_revision(from);
  entry.mod = take_revision(from);
  entry.gone = from.flag();
  entry.value = from.text(kMaxValue, kValueLength);
  return entry;
}

/// As many entries from `next` on as fit in a message, preceded by their number.
std::string pack(const std::vector<Entry>& all, std::size_t& next, std::size_t most) {
  OctetWriter entries;
  std::size_t count = 0;
  for (; next < all.size() && count < most; ++next, ++count) {
    constexpr std::size_t fixed = 2 + 8 + 8 + 1 + kValueLength;
    if (entries.size() + fixed + size_of(all[next]) > kRoom) break;
    put_entry(entries, all[next]);
  }
  OctetWriter out;
  out.number(count, 2);
  out.append(entries.take());
  return out.take();
}

Message batch_message(std::int64_t revision, bool more, std::string_view listed) {
  OctetWriter out = begin(Kind::batch);
  put_revision(out, revision);
  out.number(more ? 1 : 0, 1);
  out.append(listed);
  return out.take();
}

/// The entries of a message. False if there are more than allowed, together with earlier ones.
bool unpack(OctetReader& from, std::vector<Entry>& into, std::size_t most) {
  const auto count = from.number(2);
  for (std::uint64_t i = 0; i < count && from.right(); ++i) {
    if (into.size() >= most) return false;
    into.push_back(take_entry(from));
  }
  return true;
}

/// The lists of a transaction, divided into messages.
class Operations {
 public:
  explicit Operations(const Txn& txn) : txn_(txn) {}

  [[nodiscard]] bool done() const { return list_ == kLists; }
  /// The next message, with as many operations as fit.
  std::string take() {
    OctetWriter listed;
    std::array<std::uint8_t, kLists> counts{};
    while (!done() && listed.size() < kRoom) {
      if (at_ == size_of_list()) {
        ++list_;
        at_ = 0;
        continue;
      }
      OctetWriter next;
      put(next);
      if (listed.size() + next.size() > kRoom) break;
      listed.append(next.take());
      ++counts.at(list_);
      ++at_;
    }
    skip_empty();
    OctetWriter out;
    for (const std::uint8_t count : counts) out.number(count, 1);
    out.append(listed.take());
    return out.take();
  }

 private:
  static constexpr std::size_t kLists = 4;

  [[nodiscard]] std::size_t size_of_list() const {
    switch (list_) {
      case 0:
        return txn_.compares.size();
      case 1:
        return txn_.puts.size();
      case 2:
        return txn_.deletes.size();
      default:
        return txn_.else_get.size();
    }
  }
  void skip_empty() {
    while (!done() && at_ == size_of_list()) {
      ++list_;
      at_ = 0;
    }
  }
  void put(OctetWriter& to) const {
    if (list_ == 0) {
      const Compare& compare = txn_.compares[at_];
      to.number(static_cast<std::uint64_t>(compare.what), 1);
      to.number(static_cast<std::uint64_t>(compare.is), 1);
      to.text(compare.key);
      put_revision(to, compare.revision);
    } else if (list_ == 1) {
      to.text(txn_.puts[at_].key);
      to.text(txn_.puts[at_].value, kValueLength);
    } else {
      to.text((list_ == 2 ? txn_.deletes : txn_.else_get)[at_]);
    }
  }

  const Txn& txn_;
  std::size_t list_ = 0;
  std::size_t at_ = 0;
};

Compare take_compare(OctetReader& from) {
  Compare out{};
  out.what = from.word(Compare::What::create);
  out.is = from.word(Compare::Is::less);
  out.key = take_key(from);
  out.revision = take_revision(from);
  return out;
}
Put take_put(OctetReader& from) {
  Put out;
  out.key = take_key(from);
  out.value = from.text(kMaxValue, kValueLength);
  return out;
}

template <class T>
void take_all(OctetReader& from, std::vector<T>& into, std::size_t count, T (*take)(OctetReader&)) {
  for (std::size_t i = 0; i < count && from.right(); ++i) into.push_back(take(from));
}

std::string misfit_of_keys(const std::vector<std::string>& keys) {
  for (const auto& key : keys)
    if (key.empty() || key.size() > kMaxKey) return "a key is empty or too long";
  return {};
}

std::size_t bytes_of(const Txn& txn) {
  std::size_t bytes = 0;
  for (const auto& compare : txn.compares) bytes += compare.key.size();
  for (const auto& put : txn.puts) bytes += put.key.size() + put.value.size();
  for (const auto& key : txn.deletes) bytes += key.size();
  for (const auto& key : txn.else_get) bytes += key.size();
  return bytes;
}

std::unexpected<Error> not_understood() { return fail("it sent a message that is not understood"); }

Hello take_hello(OctetReader& from) {
  if (from.number(1) != kWireVersion) from.refuse();
  Hello out;
  out.cluster = from.text(kMaxWords);
  out.gateway = from.text(kMaxWords);
  return out;
}

std::string take_prefix(OctetReader& from) {
  std::string prefix = from.text(kMaxPrefix);
  if (prefix.empty()) from.refuse();
  return prefix;
}

Follow take_follow(OctetReader& from) {
  Follow out;
  const auto count = static_cast<std::size_t>(from.number(1));
  if (count > kMaxPrefixes) from.refuse();
  take_all(from, out.prefixes, count, take_prefix);
  return out;
}

StoreState take_state(OctetReader& from) {
  StoreState out{};
  out.reachable = from.flag();
  out.no_space = from.flag();
  out.cluster_id = from.number(8);
  out.latency_ns = from.number(8);
  out.db_bytes = from.number(8);
  out.endpoint = from.text(kMaxWords);
  out.problem = from.text(kMaxWords);
  return out;
}

}  // namespace

std::string misfit_of(const Txn& txn) {
  if (std::max({txn.compares.size(), txn.puts.size() + txn.deletes.size(), txn.else_get.size()}) >
      kMaxOperations)
    return "it has more than " + std::to_string(kMaxOperations) + " comparisons, changes or reads";
  for (const auto& compare : txn.compares)
    if (auto misfit = misfit_of_keys({compare.key}); !misfit.empty()) return misfit;
  for (const auto& put : txn.puts) {
    if (auto misfit = misfit_of_keys({put.key}); !misfit.empty()) return misfit;
    if (put.value.size() > kMaxValue) return "a value is too long";
  }
  for (const auto* keys : {&txn.deletes, &txn.else_get})
    if (auto misfit = misfit_of_keys(*keys); !misfit.empty()) return misfit;
  if (bytes_of(txn) > kMaxTransaction) return "it is too long";
  return {};
}

Entry bounded(Entry entry) {
  // No protobuf message begins with an octet 0xff that has no successor.
  constexpr char nobody_understands = '\xff';
  if (entry.key.size() > kMaxKey) {
    // Two different keys stay different, and a deletion gets the same cut key as the entry.
    const std::string hash = nobody_understands + hexadecimal(hash_of(entry.key));
    entry.key = entry.key.substr(0, kMaxKey - hash.size()) + hash;
    entry.value = nobody_understands;
  }
  if (entry.value.size() > kMaxValue) entry.value = nobody_understands;
  return entry;
}

Message message_of(const Hello& hello) {
  OctetWriter out = begin(Kind::hello);
  out.number(kWireVersion, 1);
  put_words(out, hello.cluster);
  put_words(out, hello.gateway);
  return out.take();
}

Message message_of(const Follow& follow) {
  OctetWriter out = begin(Kind::follow);
  const std::size_t count = std::min(follow.prefixes.size(), kMaxPrefixes);
  out.number(count, 1);
  for (std::size_t i = 0; i < count; ++i)
    out.text(std::string_view(follow.prefixes[i]).substr(0, kMaxPrefix));
  return out.take();
}

Message message_of(const Credit& credit) {
  OctetWriter out = begin(Kind::credit);
  out.number(credit.entries, 4);
  return out.take();
}

std::vector<Message> messages_of(const Txn& txn) {
  std::vector<Message> out;
  Operations operations(txn);
  do {
    const std::string listed = operations.take();
    OctetWriter message = begin(Kind::txn);
    message.number(txn.id, 8);
    message.number(std::min<std::uint64_t>((txn.patience_ns + kMilli - 1) / kMilli,
                                           std::numeric_limits<std::uint32_t>::max()),
                   4);
    message.number(operations.done() ? 0 : 1, 1);
    message.append(listed);
    out.push_back(message.take());
  } while (!operations.done());
  return out;
}

Message message_of(const StoreState& state) {
  OctetWriter out = begin(Kind::state);
  out.number(state.reachable ? 1 : 0, 1);
  out.number(state.no_space ? 1 : 0, 1);
  out.number(state.cluster_id, 8);
  out.number(state.latency_ns, 8);
  out.number(state.db_bytes, 8);
  put_words(out, state.endpoint);
  put_words(out, state.problem);
  return out.take();
}

Message message_of(const ClusterSnapshot& snapshot) {
  OctetWriter out = begin(Kind::begin);
  put_revision(out, snapshot.revision);
  return out.take();
}

Message message_of(const ClusterSynced& synced) {
  OctetWriter out = begin(Kind::synced);
  put_revision(out, synced.revision);
  return out.take();
}

Message message_of(const Batch& batch, std::size_t& next, std::size_t most, bool more) {
  const std::string listed = pack(batch.entries, next, most);
  return batch_message(batch.revision, more || next < batch.entries.size(), listed);
}

Message page_of(const Batch& batch, std::size_t& next, std::size_t most) {
  return batch_message(batch.revision, false, pack(batch.entries, next, most));
}

std::vector<Message> messages_of(const TxnResult& result) {
  std::vector<Message> out;
  std::size_t next = 0;
  do {
    const std::string listed = pack(result.read, next, kMaxOperations);
    OctetWriter message = begin(Kind::result);
    message.number(result.id, 8);
    message.number(static_cast<std::uint64_t>(result.outcome), 1);
    put_revision(message, result.revision);
    message.number(next < result.read.size() ? 1 : 0, 1);
    message.append(listed);
    put_words(message, result.why);
    out.push_back(message.take());
  } while (next < result.read.size());
  return out;
}

Result<std::optional<ToStore>> ReaderOfGateway::take(Octets message) {
  OctetReader from(message);
  const auto kind = static_cast<Kind>(from.number(1));
  if (begun_ && kind != Kind::txn) return not_understood();
  std::optional<ToStore> out;
  switch (kind) {
    case Kind::hello:
      out = take_hello(from);
      break;
    case Kind::follow:
      out = take_follow(from);
      break;
    case Kind::credit:
      out = Credit{static_cast<std::uint32_t>(from.number(4))};
      break;
    case Kind::txn:
      bytes_ += message.size();
      out = take_txn(from);
      break;
    default:
      return not_understood();
  }
  if (!from.ended_well()) return not_understood();
  return out;
}

std::optional<ToStore> ReaderOfGateway::take_txn(OctetReader& from) {
  const std::uint64_t id = from.number(8);
  if (!begun_) {
    begun_.emplace();
    begun_->id = id;
  }
  begun_->patience_ns = from.number(4) * kMilli;
  const bool more = from.flag();
  std::array<std::size_t, 4> counts{};
  for (std::size_t& count : counts) count = static_cast<std::size_t>(from.number(1));
  take_all(from, begun_->compares, counts[0], take_compare);
  take_all(from, begun_->puts, counts[1], take_put);
  take_all(from, begun_->deletes, counts[2], take_key);
  take_all(from, begun_->else_get, counts[3], take_key);
  // Each part has some octets that are not of keys and values.
  if (id != begun_->id || bytes_ > 2 * kMaxTransaction || !misfit_of(*begun_).empty())
    from.refuse();
  if (more) return std::nullopt;
  bytes_ = 0;
  return std::exchange(begun_, std::nullopt).value();
}

Result<ReaderOfStore::Read> ReaderOfStore::take(Octets message) {
  OctetReader from(message);
  Read out;
  switch (static_cast<Kind>(from.number(1))) {
    case Kind::state:
      out.whole = take_state(from);
      break;
    case Kind::begin:
      batch_.reset();
      out.whole = ClusterSnapshot{take_revision(from)};
      break;
    case Kind::synced:
      out.whole = ClusterSynced{take_revision(from)};
      break;
    case Kind::batch:
      out = take_batch(from);
      break;
    case Kind::result:
      out.whole = take_result(from);
      break;
    default:
      return not_understood();
  }
  if (!from.ended_well()) return not_understood();
  return out;
}

ReaderOfStore::Read ReaderOfStore::take_batch(OctetReader& from) {
  const std::int64_t revision = take_revision(from);
  const bool more = from.flag();
  if (!batch_) {
    batch_ = Batch{.revision = revision, .entries = {}};
    bytes_ = 0;
  }
  const std::size_t before = batch_->entries.size();
  if (!unpack(from, batch_->entries, kMaxBatch) || revision != batch_->revision) from.refuse();
  Read out;
  out.entries = batch_->entries.size() - before;
  for (std::size_t i = before; i < batch_->entries.size(); ++i)
    bytes_ += size_of(batch_->entries[i]);
  if (bytes_ > kMaxBatchBytes) from.refuse();
  if (!more) out.whole = std::exchange(batch_, std::nullopt).value();
  return out;
}

std::optional<ClusterMessage> ReaderOfStore::take_result(OctetReader& from) {
  const std::uint64_t id = from.number(8);
  if (!result_) {
    result_.emplace();
    result_->id = id;
  }
  result_->outcome = from.word(Outcome::invalid);
  result_->revision = take_revision(from);
  const bool more = from.flag();
  if (!unpack(from, result_->read, kMaxOperations) || id != result_->id) from.refuse();
  result_->why = from.text(kMaxWords);
  if (more) return std::nullopt;
  return std::exchange(result_, std::nullopt).value();
}

}  // namespace mlcca::cluster::wire
