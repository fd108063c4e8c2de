// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/etcd.hpp"

#include <protozero/pbf_reader.hpp>
#include <protozero/pbf_writer.hpp>

namespace mlcca::cluster::etcd {
namespace {

using core::cluster::Compare;
using core::cluster::Entry;
using core::cluster::Txn;
using protozero::pbf_reader;
using protozero::pbf_wire_type;
using protozero::pbf_writer;

struct NotUnderstood {};

// Field numbers of the messages, from rpc.proto and kv.proto of etcd 3.4.
namespace range_field {
enum : std::uint8_t { key = 1, end = 2, limit = 3, revision = 4 };
}
namespace compare_field {
enum : std::uint8_t { result = 1, target = 2, key = 3, create = 5, mod = 6 };
constexpr int kEqual = 0;
constexpr int kLess = 2;
constexpr int kCreate = 1;
constexpr int kMod = 2;
}  // namespace compare_field
namespace operation {
enum : std::uint8_t { range = 1, put = 2, erase = 3 };
}
namespace txn_field {
enum : std::uint8_t { compare = 1, success = 2, failure = 3 };
}
namespace watch_field {
enum : std::uint8_t { create = 1, key = 1, end = 2, revision = 3, progress = 4 };
}

std::int64_t number_of(pbf_reader& from) {
  if (from.wire_type() != pbf_wire_type::varint) throw NotUnderstood{};
  return static_cast<std::int64_t>(from.get_uint64());
}
std::int64_t revision_of(pbf_reader& from) {
  const std::int64_t revision = number_of(from);
  if (revision < 0) throw NotUnderstood{};
  return revision;
}
protozero::data_view octets_of(pbf_reader& from) {
  if (from.wire_type() != pbf_wire_type::length_delimited) throw NotUnderstood{};
  return from.get_view();
}
std::string text_of(pbf_reader& from) {
  const auto view = octets_of(from);
  return {view.data(), view.size()};
}
/// Calls `take` with the number of each field; it returns false for a field that is to be skipped.
template <class Take>
void each_field(protozero::data_view octets, Take take) {
  pbf_reader from(octets);
  while (from.next())
    if (!take(from.tag(), from)) from.skip();
}

Header header_of(protozero::data_view octets) {
  Header out;
  each_field(octets, [&out](auto tag, pbf_reader& from) {
    if (tag == 1)
      out.cluster_id = static_cast<std::uint64_t>(number_of(from));
    else if (tag == 3)
      out.revision = revision_of(from);
    else
      return false;
    return true;
  });
  return out;
}

/// Decodes a KeyValue.
Entry entry_of(protozero::data_view octets) {
  Entry out;
  each_field(octets, [&out](auto tag, pbf_reader& from) {
    if (tag == 1)
      out.key = text_of(from);
    else if (tag == 2)
      out.create = revision_of(from);
    else if (tag == 3)
      out.mod = revision_of(from);
    else if (tag == 5)
      out.value = text_of(from);
    else
      return false;
    return true;
  });
  if (out.key.empty()) throw NotUnderstood{};
  return out;
}

void add(std::vector<Entry>& to, Entry entry) {
  if (to.size() == kMostEntries) throw NotUnderstood{};
  to.push_back(std::move(entry));
}

/// Decodes a RangeResponse.
Page page_of(protozero::data_view octets) {
  Page out;
  each_field(octets, [&out](auto tag, pbf_reader& from) {
    if (tag == 1)
      out.header = header_of(octets_of(from));
    else if (tag == 2)
      add(out.entries, entry_of(octets_of(from)));
    else if (tag == 3)
      out.more = number_of(from) != 0;
    else
      return false;
    return true;
  });
  return out;
}

/// Decodes an Event of a watch.
Entry event_of(protozero::data_view octets) {
  Entry out;
  bool gone = false;
  each_field(octets, [&](auto tag, pbf_reader& from) {
    if (tag == 1)
      gone = number_of(from) != 0;
    else if (tag == 2)
      out = entry_of(octets_of(from));
    else
      return false;
    return true;
  });
  if (out.key.empty()) throw NotUnderstood{};
  out.gone = gone;
  return out;
}

/// Decodes a ResponseOp of a range; it is the only kind that a failed comparison can give.
Page range_in(protozero::data_view octets) {
  Page out;
  each_field(octets, [&out](auto tag, pbf_reader& from) {
    if (tag != operation::range) return false;
    out = page_of(octets_of(from));
    return true;
  });
  return out;
}

/// The entry of each key, from the pages that its range request gave.
std::vector<Entry> entries_of(std::vector<Page>& pages, const std::vector<std::string>& keys) {
  if (pages.size() != keys.size()) throw NotUnderstood{};
  std::vector<Entry> out;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    auto& there = pages[i].entries;
    if (there.size() > 1 || (!there.empty() && there[0].key != keys[i])) throw NotUnderstood{};
    if (there.empty())
      out.push_back({.key = keys[i], .value = {}, .create = 0, .mod = 0, .gone = true});
    else
      out.push_back(std::move(there[0]));
  }
  return out;
}

template <class Read>
auto read(std::string_view answer, Read of) -> std::optional<decltype(of(protozero::data_view()))> {
  try {
    return of(protozero::data_view(answer.data(), answer.size()));
  } catch (const protozero::exception&) {
    return std::nullopt;
  } catch (const NotUnderstood&) {
    return std::nullopt;
  }
}

void put_range(pbf_writer& to, std::string_view key, std::string_view end) {
  to.add_bytes(range_field::key, key.data(), key.size());
  if (!end.empty()) to.add_bytes(range_field::end, end.data(), end.size());
}

void put_compare(std::string& to, const Compare& compare) {
  pbf_writer request(to);
  pbf_writer out(request, txn_field::compare);
  const bool mod = compare.what == Compare::What::mod;
  const bool less = compare.is == Compare::Is::less;
  out.add_enum(compare_field::result, less ? compare_field::kLess : compare_field::kEqual);
  out.add_enum(compare_field::target, mod ? compare_field::kMod : compare_field::kCreate);
  out.add_bytes(compare_field::key, compare.key);
  out.add_int64(mod ? compare_field::mod : compare_field::create, compare.revision);
}

/// Adds an operation to a branch of a transaction; `fill` writes it.
template <class Fill>
void put_operation(std::string& to, std::uint8_t branch, std::uint8_t kind, Fill fill) {
  pbf_writer request(to);
  pbf_writer one(request, branch);
  pbf_writer out(one, kind);
  fill(out);
}

}  // namespace

std::string end_of(std::string_view prefix) {
  std::string end(prefix);
  while (!end.empty() && end.back() == '\xff') end.pop_back();
  using namespace std::string_literals;
  if (end.empty()) return "\0"s;  // etcd takes this for: all keys that follow
  end.back() = static_cast<char>(static_cast<unsigned char>(end.back()) + 1);
  return end;
}

std::string range_request(std::string_view key, std::string_view end, std::uint64_t limit,
                          std::int64_t revision) {
  std::string out;
  pbf_writer to(out);
  put_range(to, key, end);
  to.add_uint64(range_field::limit, limit);
  to.add_int64(range_field::revision, revision);
  return out;
}

std::optional<Page> read_page(std::string_view answer) { return read(answer, page_of); }

std::string txn_request(const Txn& txn) {
  std::string out;
  for (const auto& compare : txn.compares) put_compare(out, compare);
  for (const auto& put : txn.puts)
    put_operation(out, txn_field::success, operation::put, [&put](pbf_writer& to) {
      to.add_bytes(1, put.key);
      to.add_bytes(2, put.value);
    });
  for (const auto& key : txn.deletes)
    put_operation(out, txn_field::success, operation::erase,
                  [&key](pbf_writer& to) { to.add_bytes(1, key); });
  for (const auto& key : txn.else_get)
    put_operation(out, txn_field::failure, operation::range,
                  [&key](pbf_writer& to) { put_range(to, key, {}); });
  return out;
}

std::optional<TxnAnswer> read_txn(std::string_view answer, const std::vector<std::string>& gets) {
  return read(answer, [&gets](protozero::data_view octets) {
    TxnAnswer out;
    std::vector<Page> pages;
    each_field(octets, [&](auto tag, pbf_reader& from) {
      if (tag == 1)
        out.header = header_of(octets_of(from));
      else if (tag == 2)
        out.succeeded = number_of(from) != 0;
      else if (tag == 3)
        pages.push_back(range_in(octets_of(from)));
      else
        return false;
      if (pages.size() > kMostEntries) throw NotUnderstood{};
      return true;
    });
    if (!out.succeeded) out.read = entries_of(pages, gets);
    return out;
  });
}

std::string watch_request(std::string_view key, std::string_view end, std::int64_t revision) {
  std::string out;
  {  // the destructor of `to` writes the length
    pbf_writer request(out);
    pbf_writer to(request, watch_field::create);
    to.add_bytes(watch_field::key, key.data(), key.size());
    to.add_bytes(watch_field::end, end.data(), end.size());
    to.add_int64(watch_field::revision, revision);
  }
  return out;
}

std::optional<Changes> read_changes(std::string_view answer) {
  return read(answer, [](protozero::data_view octets) {
    Changes out;
    each_field(octets, [&out](auto tag, pbf_reader& from) {
      if (tag == 1)
        out.header = header_of(octets_of(from));
      else if (tag == 3)
        out.created = number_of(from) != 0;
      else if (tag == 4)
        out.canceled = number_of(from) != 0;
      else if (tag == 5)
        out.compacted = revision_of(from);
      else if (tag == 6)
        out.reason = text_of(from);
      else if (tag == 7)
        throw NotUnderstood{};  // part of a revision: fragments were not requested
      else if (tag == 11)
        add(out.entries, event_of(octets_of(from)));
      else
        return false;
      return true;
    });
    return out;
  });
}

std::optional<Status> read_status(std::string_view answer) {
  return read(answer, [](protozero::data_view octets) {
    Status out;
    each_field(octets, [&out](auto tag, pbf_reader& from) {
      if (tag == 1)
        out.header = header_of(octets_of(from));
      else if (tag == 3)
        out.db_bytes = static_cast<std::uint64_t>(number_of(from));
      else if (tag == 4)
        out.leader = static_cast<std::uint64_t>(number_of(from));
      else if (tag == 8)
        out.no_space = out.no_space || text_of(from).find("NOSPACE") != std::string::npos;
      else
        return false;
      return true;
    });
    return out;
  });
}

}  // namespace mlcca::cluster::etcd
