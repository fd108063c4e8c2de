// SPDX-License-Identifier: BSD-2-Clause
// The stages in their order: file, document, draft, names, rules.
#include "description/read.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <utility>

#include "core/handle.hpp"
#include "core/result.hpp"
#include "description/draft.hpp"
#include "description/problems.hpp"
#include "description/rules.hpp"
#include "description/xml.hpp"

namespace mlcca::description {
namespace {

/// At most one byte more than the limit, so that a file that grows while it is read is noticed.
Result<std::string> contents(const std::string& path) {
  // A FIFO must not hold the daemon: it is opened without waiting, then refused.
  const Fd fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (!fd) return fail(fmt::format("cannot open the file: {}", std::strerror(errno)));
  struct stat status{};
  if (::fstat(fd.get(), &status) != 0)
    return fail(fmt::format("cannot examine the file: {}", std::strerror(errno)));
  if (!S_ISREG(status.st_mode)) return fail("not a regular file: a description must be one");
  const auto most = kMaxFileBytes + 1;
  const auto expected = static_cast<std::size_t>(std::max<off_t>(status.st_size, 0)) + 1;
  std::string text;
  text.resize(std::min(expected, most));
  std::size_t size = 0;
  while (size < text.size()) {
    const auto got = ::read(fd.get(), text.data() + size, text.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return fail(fmt::format("cannot read the file: {}", std::strerror(errno)));
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
    if (size == text.size() && size < most) text.resize(std::min(size * 2, most));
  }
  text.resize(size);
  return text;
}

}  // namespace

Description read_memory(std::string_view xml, const std::string& name) {
  Problems problems(name);
  Draft draft;
  const bool valid = parse(
      xml, problems, [&](const Element& root) { draft.name = root.attribute("name"); },
      [&](const Element& part) { add_part(part, draft, problems); });
  // Names that an invalid part would have defined are not known: looking them up would accuse
  // those who use them.
  if (!valid) return std::unexpected(problems.take());
  auto system = resolve(std::move(draft), problems);
  check_rules(system, problems);
  if (!problems.empty()) return std::unexpected(problems.take());
  return system;
}

Description read(const std::string& path) {
  const auto text = contents(path);
  if (!text) return std::unexpected(std::vector<Problem>{{path, 0, "", text.error().text}});
  return read_memory(*text, path);
}

}  // namespace mlcca::description
