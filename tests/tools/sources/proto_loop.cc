// SPDX-License-Identifier: BSD-2-Clause
#include "tests/tools/sources/proto_loop.hpp"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "tools/sources/open.hpp"

namespace mlcca::test {

using core::mesh::Sample;
using core::mesh::Snapshot;

Watched::Watched(const core::mesh::Source& source, const core::mesh::Mesh& mesh, sd_event* loop)
    : Watched(
          [&](sd_event* on, net::LinkSource::Report report) {
            return net::open_here(source, mesh, on, std::move(report));
          },
          loop) {}

Watched::Watched(const Open& open, sd_event* loop) : loop_(sd_event_ref(loop)) {
  sd_event* raw = nullptr;
  if (loop == nullptr && sd_event_new(&raw) < 0) std::abort();
  if (loop == nullptr) loop_.reset(raw);
  auto opened = open(loop_.get(), [this](Snapshot snapshot) {
    if (fits_ != nullptr && !found_ && (*fits_)(snapshot)) found_ = snapshot;
    reported_ = std::move(snapshot);
  });
  if (opened)
    source_ = std::move(*opened);
  else
    error_ = opened.error().text;
}

std::optional<Snapshot> Watched::await(const Predicate& fits) {
  constexpr std::chrono::seconds kPatience{30};
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  found_.reset();
  fits_ = &fits;
  while (!found_ && std::chrono::steady_clock::now() < deadline)
    if (sd_event_run(loop_.get(), 1'000'000) < 0) break;
  fits_ = nullptr;
  return found_;
}

std::string Watched::last() const {
  if (!reported_) return "nothing";
  std::string out = "problem: " + reported_->problem + "\n";
  for (const auto& s : reported_->links)
    out += s.from + " -> " + s.to + " " + std::to_string(s.rate) + " bit/s loss " +
           (s.loss ? std::to_string(*s.loss) : "?") + "\n";
  for (const auto& h : reported_->next_hops) out += h.from + " => " + h.to + " via " + h.via + "\n";
  return out;
}

core::mesh::Mesh mesh_of(const std::vector<std::string>& addresses) {
  core::mesh::Mesh mesh;
  for (const auto& address : addresses) {
    core::mesh::Node node;
    node.name = "n" + std::to_string(mesh.nodes.size() + 1);
    node.address = address;
    mesh.nodes.push_back(std::move(node));
  }
  return mesh;
}

const Sample* find(const Snapshot& snapshot, const std::string& from, const std::string& to) {
  for (const auto& sample : snapshot.links)
    if (sample.from == from && sample.to == to) return &sample;
  return nullptr;
}

Folder::Folder() {
  path_ = (std::filesystem::temp_directory_path() / "mlcca-sources-XXXXXX").string();
  if (::mkdtemp(path_.data()) == nullptr) std::abort();
}

Folder::~Folder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace mlcca::test
