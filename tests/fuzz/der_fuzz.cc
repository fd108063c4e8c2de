// SPDX-License-Identifier: BSD-2-Clause
// Any octets at all into the readers of the run-time representation. The sanitizers watch what is
// read; here: what is understood encodes to the same octets, and the small reader understands
// nothing else.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "mlcca/der.hpp"
#include "mlcca/der_narrow.hpp"

namespace {

using namespace mlcca;

void demand(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

std::vector<uint8_t> encode_again(const der::Decoded& decoded) {
  std::vector<der::UserAttribute> users;
  for (const der::UserAttribute& user : decoded.user) users.push_back(user);
  std::vector<uint8_t> octets(der::kMaxSize);
  octets.resize(
      der::encode({decoded.role, decoded.subject, decoded.attributes, users.data(), users.size()},
                  octets.data(), octets.size()));
  return octets;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  der::Decoded wide;
  const der::Status status = der::decode(data, size, &wide);
  demand(status.ok() ? status.offset == 0 : status.offset <= size, "offset outside of the octets");
  if (status.ok())
    demand(encode_again(wide) == std::vector<uint8_t>(data, data + size), "not the one encoding");

  der::NarrowDecoded<Units16, Side::requirement> requirement;
  der::NarrowDecoded<Units32, Side::provision> provision;
  const bool plain = status.ok() && wide.user.empty();
  const bool network = wide.role == der::Role::network;
  if (der::decode(data, size, &requirement).ok())
    demand(plain && !network, "a requirement for the small reader only");
  if (der::decode(data, size, &provision).ok())
    demand(plain && network, "a provision for the small reader only");
  return 0;
}
