// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/net/sources/facts.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "base/octets.hpp"
#include "base/text.hpp"
#include "core/mesh/bounds.hpp"
#include "core/mesh/link_table.hpp"

namespace mlcca::net::facts {
namespace {

using core::mesh::NextHop;
using core::mesh::Node;
using core::mesh::RateKind;
using core::mesh::Sample;
using core::mesh::Snapshot;

enum class Kind : std::uint8_t { none = 0, nodes = 1, watch = 2, links = 3, hops = 4, end = 5 };

constexpr std::size_t kMaxText = 1024;                     // of any text: paths are longest
constexpr std::size_t kRoom = kMaxMessage - 4 * kMaxText;  // room for one more fact

class Writer : public OctetWriter {
 public:
  void text(std::string_view value) { OctetWriter::text(cut(value, kMaxText)); }
  template <class T>
  void maybe(const std::optional<T>& value, std::size_t octets) {
    number(value.has_value() ? 1 : 0, 1);
    if (value) number(*value, octets);
  }
};

class Reader : public OctetReader {
 public:
  using OctetReader::OctetReader;
  std::string text() { return OctetReader::text(kMaxText); }
  std::optional<std::uint64_t> maybe(std::size_t octets) {
    return flag() ? std::optional(number(octets)) : std::nullopt;
  }
};

/// Packs facts into messages of one kind, each with as many facts as fit.
template <class Fact, class Write>
void pack(Kind kind, const std::vector<Fact>& all, Write write, std::vector<Message>& into) {
  for (std::size_t next = 0; next < all.size();) {
    Writer facts;
    std::size_t count = 0;
    for (; next < all.size() && facts.size() < kRoom; ++next, ++count) write(facts, all[next]);
    Writer message;
    message.number(static_cast<std::uint64_t>(kind), 1);
    message.number(count, 2);
    into.push_back(message.take() + facts.take());
  }
}

void write(Writer& to, const Sample& s) {
  to.text(s.from);
  to.text(s.to);
  to.number(s.rate, 8);
  to.number(static_cast<std::uint64_t>(s.kind), 1);
  to.maybe(s.loss, 8);
  to.maybe(s.channel, 4);
  to.maybe(s.busy, 4);
  to.maybe(s.weight, 8);
  to.number(s.taken, 8);
  to.maybe(s.valid, 8);
}

template <class To>
std::optional<To> narrow(std::optional<std::uint64_t> value) {
  if (!value) return std::nullopt;
  return static_cast<To>(*value);
}

Sample read_sample(Reader& from) {
  Sample s;
  s.from = from.text();
  s.to = from.text();
  s.rate = from.number(8);
  s.kind = from.word(RateKind::derived);
  s.loss = from.maybe(8);
  s.channel = narrow<std::uint32_t>(from.maybe(4));
  s.busy = narrow<std::uint32_t>(from.maybe(4));
  s.weight = from.maybe(8);
  s.taken = from.number(8);
  s.valid = from.maybe(8);
  return s;
}

NextHop read_hop(Reader& from) {
  NextHop hop;
  hop.from = from.text();
  hop.to = from.text();
  hop.via = from.text();
  return hop;
}

/// False if there are more facts than allowed.
template <class Fact>
bool unpack(Reader& from, std::vector<Fact>& into, Fact (*read)(Reader&), std::size_t most) {
  const auto count = from.number(2);
  for (std::uint64_t i = 0; i < count && from.right(); ++i) {
    if (into.size() >= most) return false;
    into.push_back(read(from));
  }
  return true;
}

std::unexpected<Error> not_understood() { return fail("it sent a message that is not understood"); }

}  // namespace

std::vector<Message> question(const core::mesh::Source& source, const core::mesh::Mesh& mesh) {
  std::vector<Message> out;
  pack(
      Kind::nodes, mesh.nodes,
      [](Writer& to, const Node& node) {
        to.text(node.name);
        to.text(node.address);
      },
      out);
  Writer last;
  last.number(static_cast<std::uint64_t>(Kind::watch), 1);
  last.number(static_cast<std::uint64_t>(source.kind), 1);
  last.number(static_cast<std::uint64_t>(source.metric), 1);
  last.text(source.interface);
  last.text(source.endpoint);
  out.push_back(last.take());
  return out;
}

std::vector<Message> answer(const Snapshot& snapshot) {
  std::vector<Message> out;
  pack(Kind::links, snapshot.links, write, out);
  pack(
      Kind::hops, snapshot.next_hops,
      [](Writer& to, const NextHop& hop) {
        to.text(hop.from);
        to.text(hop.to);
        to.text(hop.via);
      },
      out);
  Writer last;
  last.number(static_cast<std::uint64_t>(Kind::end), 1);
  last.text(snapshot.problem);
  out.push_back(last.take());
  return out;
}

Result<std::optional<Question>> QuestionReader::take(Octets message) {
  Reader from(message);
  const auto kind = static_cast<Kind>(from.number(1));
  if (kind == Kind::nodes) {
    const auto read = [](Reader& r) {
      Node node;
      node.name = r.text();
      node.address = r.text();
      return node;
    };
    if (!unpack<Node>(from, question_.mesh.nodes, read, core::mesh::kMaxNodes) ||
        !from.ended_well())
      return not_understood();
    return std::nullopt;
  }
  if (kind != Kind::watch) return not_understood();
  question_.source.kind = from.word(core::mesh::SourceKind::wire);
  question_.source.metric = from.word(core::mesh::AwdsMetric::transmission_time);
  question_.source.interface = from.text();
  question_.source.endpoint = from.text();
  if (!from.ended_well()) return not_understood();
  return std::exchange(question_, {});
}

Result<std::optional<Snapshot>> AnswerReader::take(Octets message) {
  Reader from(message);
  switch (static_cast<Kind>(from.number(1))) {
    case Kind::links:
      if (!unpack(from, snapshot_.links, read_sample, core::mesh::kMaxFacts))
        return not_understood();
      break;
    case Kind::hops:
      if (!unpack(from, snapshot_.next_hops, read_hop, core::mesh::kMaxFacts))
        return not_understood();
      break;
    case Kind::end:
      snapshot_.problem = from.text();
      if (!from.ended_well()) return not_understood();
      return std::exchange(snapshot_, {});
    default:
      return not_understood();
  }
  if (!from.ended_well()) return not_understood();
  return std::nullopt;
}

}  // namespace mlcca::net::facts
