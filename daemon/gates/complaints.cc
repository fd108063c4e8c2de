// SPDX-License-Identifier: BSD-2-Clause
#include "daemon/gates/complaints.hpp"

#include <bpf/libbpf.h>

#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace mlcca::gates {
namespace {

constexpr std::size_t kMostText = 600;  // a verifier log is long; its end has the reason

Complaints* innermost = nullptr;  // NOLINT(*-avoid-non-const-global-variables): see the header

int collect(libbpf_print_level level, const char* format, va_list arguments) {
  if (level == LIBBPF_DEBUG || innermost == nullptr) return 0;
  std::array<char, 4096> line{};
  std::vsnprintf(line.data(), line.size(), format, arguments);  // NOLINT(*-valist.Uninitialized)
  innermost->add(line.data());
  return 0;
}

}  // namespace

Complaints::Complaints() : outer_(innermost) {
  innermost = this;
  libbpf_set_print(collect);
}

Complaints::~Complaints() { innermost = outer_; }

void Complaints::add(const std::string& line) {
  text_ += line;
  if (text_.size() > kMostText) text_.erase(0, text_.size() - kMostText);
}

std::unexpected<Error> Complaints::error(const std::string& call, int error) const {
  std::string text = call + ": " + std::strerror(std::abs(error));  // NOLINT(concurrency-mt-unsafe)
  if (!text_.empty()) {
    std::string said = text_;
    for (char& c : said)
      if (c == '\n') c = ' ';
    text += " (" + said + ")";
  }
  return fail(std::move(text));
}

}  // namespace mlcca::gates
