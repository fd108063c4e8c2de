// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gateway/uploads.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

namespace mlcca {
namespace {

constexpr const char* kTooLong = "it was not complete after a minute";
constexpr const char* kTooMany = "too many others were being handed over";

}  // namespace

void Uploads::give_up(Upload& upload, std::string why) {
  upload.text = std::string();
  upload.given_up = std::move(why);
}

void Uploads::make_room() {
  const auto of = [this](uid_t user) {
    return std::ranges::count_if(all_, [user](const auto& entry) {
      return entry.second.user == user && entry.second.given_up.empty();
    });
  };
  std::size_t open = 0;
  Upload* first = nullptr;
  for (auto& [session, upload] : all_) {
    if (!upload.given_up.empty()) continue;
    ++open;
    if (first == nullptr ||
        std::pair(-of(upload.user), upload.begun) < std::pair(-of(first->user), first->begun))
      first = &upload;
  }
  if (open >= kMost) give_up(*first, kTooMany);
}

Result<std::size_t> Uploads::add(std::uint64_t session, uid_t user, std::string_view part) {
  if (!all_.contains(session)) {
    make_room();
    all_[session] = {.user = user, .begun = clock_.monotonic_ns(), .text = {}, .given_up = {}};
  }
  Upload& upload = all_[session];
  if (upload.text.size() + part.size() > most_)
    give_up(upload, fmt::format("it has more than {} bytes", most_));
  if (!upload.given_up.empty()) {
    const std::string why = upload.given_up;
    all_.erase(session);
    return fail("what was handed over was given up: " + why);
  }
  upload.text += part;
  return upload.text.size();
}

Result<std::string> Uploads::finish(std::uint64_t session, uid_t user, std::string_view part) {
  if (!all_.contains(session) && part.size() <= most_) return std::string(part);
  if (const auto size = add(session, user, part); !size) return std::unexpected(size.error());
  std::string text = std::move(all_[session].text);
  all_.erase(session);
  return text;
}

void Uploads::poll() {
  const std::uint64_t now = clock_.monotonic_ns();
  for (auto& [session, upload] : all_)
    if (upload.given_up.empty() && now - upload.begun > kLongest) give_up(upload, kTooLong);
}

}  // namespace mlcca
