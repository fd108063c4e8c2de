// SPDX-License-Identifier: BSD-2-Clause
// The kernel's lists of TCP sockets, /proc/net/tcp and tcp6. They may be long, and none of it is
// kept.
#pragma once
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <string>
#include <string_view>

namespace mlcca {

/// Bytes of one list that are read: some 400,000 sockets.
inline constexpr std::size_t kMostTcpTable = std::size_t{64} << 20U;

/// Of a line: local end 1, remote end 2, state 3, owner 7, inode 9. Empty: there is none.
using TcpColumns = std::array<std::string_view, 10>;
inline TcpColumns tcp_columns(std::string_view line) {
  TcpColumns out;
  for (auto& column : out) {
    const auto begin = std::min(line.find_first_not_of(' '), line.size());
    const auto end = std::min(line.find(' ', begin), line.size());
    column = line.substr(begin, end - begin);
    line.remove_prefix(end);
  }
  return out;
}

/// Calls `on_line` with each line until it returns false. 0, or what read(2) failed with; EFBIG:
/// the list is longer than kMostTcpTable.
template <class OnLine>
int read_tcp_table(int fd, OnLine on_line) {
  std::string rest;  // of a line
  std::array<char, 16384> block{};
  for (std::size_t all = 0; all <= kMostTcpTable;) {
    const ssize_t size = ::read(fd, block.data(), block.size());
    if (size < 0) return errno;
    if (size == 0) return 0;
    all += static_cast<std::size_t>(size);
    rest.append(block.data(), static_cast<std::size_t>(size));
    std::size_t begin = 0;
    for (std::size_t end = 0; (end = rest.find('\n', begin)) != std::string::npos; begin = end + 1)
      if (!on_line(std::string_view(rest).substr(begin, end - begin))) return 0;
    rest.erase(0, begin);
  }
  return EFBIG;
}

}  // namespace mlcca
