// SPDX-License-Identifier: BSD-2-Clause
// A network namespace with devices that carry CAN frames although the kernel may have no CAN: tun
// devices take any protocol number, so tc sees ETH_P_CAN, real sockets and real forwarding.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/handle.hpp"

namespace mlcca::test {

using Bytes = std::vector<std::uint8_t>;

/// A classic frame of 8 bytes.
Bytes frame(std::uint32_t can_id);

/// Moves this process into namespaces of its own, once; a new directory of a bpffs for each call.
std::string new_bpf_root();

/// A device whose far end is this object: inject() is a frame from the bus, sent() one to it.
/// What is injected reaches ingress soon, not at once: wait for what it causes.
class Bus {
 public:
  /// `ifindex` 0: the kernel chooses.
  explicit Bus(const std::string& name, std::uint32_t ifindex = 0);

  [[nodiscard]] std::uint32_t ifindex() const { return ifindex_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  void inject(const Bytes& bytes) const;
  /// The next frame that left the machine here, waited for; nothing after a generous time.
  [[nodiscard]] std::optional<Bytes> sent() const;

 private:
  std::string name_;
  Fd device_;
  std::uint32_t ifindex_ = 0;
  Fd wire_;  ///< a second device: its frames lose their socket on the way to the first
};

/// A local program that listens to the frames that have passed ingress, and sends.
class Program {
 public:
  explicit Program(const Bus& bus, std::uint32_t uid = 0);
  /// False: the gate has dropped it.
  [[nodiscard]] bool send(const Bytes& bytes) const;
  /// From now on it sends past the queueing layer, where no gate is.
  void skip_queueing() const;
  [[nodiscard]] std::optional<Bytes> received() const;

 private:
  Fd fd_;
  std::uint32_t ifindex_;
};

/// Forwards every frame that passes `from`'s ingress gate, as can-gw does.
void forward(const Bus& from, const Bus& to);

/// A program of another owner, that does the same with every frame.
Fd load_foreign(int action);
/// An XDP program of another owner that passes everything, run before tc: gives its id. Withdrawn
/// by remove_foreign_xdp().
std::uint32_t put_foreign_xdp(const std::string& interface);
void remove_foreign_xdp(const std::string& interface);
/// A filter of another owner on ingress, that leaves everything to others by default.
void add_foreign_filter(const Bus& bus, std::uint32_t priority, std::uint32_t handle,
                        int action = -1);
/// Id of the program there, 0 for none.
std::uint32_t filter_at(const Bus& bus, bool ingress, std::uint32_t priority, std::uint32_t handle);
void remove_our_filter(const Bus& bus, bool ingress);
void remove_clsact(const Bus& bus);
void add_clsact(const Bus& bus);

}  // namespace mlcca::test
