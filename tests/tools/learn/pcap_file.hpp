// SPDX-License-Identifier: BSD-2-Clause
// A pcap file with times in nanoseconds.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace mlcca::learn::test {

class PcapFile {
 public:
  explicit PcapFile(std::uint32_t link) {
    put(0xa1b23c4d, 4);
    put(2, 2);
    put(4, 2);
    put(0, 8);
    put(65'535, 4);
    put(link, 4);
  }
  void add(std::uint64_t ns, const std::vector<std::uint8_t>& packet) {
    put(ns / 1'000'000'000, 4);
    put(ns % 1'000'000'000, 4);
    put(packet.size(), 4);
    put(packet.size(), 4);
    bytes_.append(packet.begin(), packet.end());
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  void put(std::uint64_t value, unsigned bytes) {
    while (bytes-- > 0) bytes_ += static_cast<char>(value >> 8 * bytes & 0xff);
  }
  std::string bytes_;
};

}  // namespace mlcca::learn::test
