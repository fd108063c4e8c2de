// SPDX-License-Identifier: BSD-2-Clause
// Reads the kernel's tables of TCP sockets, /proc/net/tcp and tcp6, line by line: they may be long,
// and they are not kept in memory.
#pragma once
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <string>
#include <string_view>

namespace mlcca {

/// At most so many bytes of a table are read (about 400,000 sockets).
inline constexpr std::size_t kMostTcpTable = std::size_t{64} << 20U;

/// The columns of a line: local address 1, remote address 2, state 3, user 7, inode 9. A column
/// that the line does not have is empty. The views are into the line.
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

/// Calls `on_line` with each line, without its newline, until it returns false. Returns 0, the
/// errno of a read(2) that failed, or EFBIG if the table exceeds kMostTcpTable.
template <class OnLine>
int read_tcp_table(int fd, OnLine on_line) {
  std::string rest;  // the beginning of an incomplete line
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
