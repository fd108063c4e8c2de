// SPDX-License-Identifier: BSD-2-Clause
#include "cluster/outcome.hpp"

#include <string_view>

#include "cluster/grpc.hpp"

namespace mlcca::cluster {

using core::cluster::Outcome;

// The texts are those of etcd 3.4 (etcdserver/api/v3rpc/rpctypes/error.go).
Outcome outcome_of(const End& end) {
  const auto says = [&end](std::string_view words) {
    return end.text.find(words) != std::string::npos;
  };
  switch (end.status) {
    case End::kNoStatus:
      return end.sent ? Outcome::unsure : Outcome::unavailable;
    case grpc::kInvalidArgument:
      return says("revision of auth store is old") ? Outcome::stale_auth : Outcome::invalid;
    case grpc::kPermissionDenied:
    case grpc::kUnauthenticated:
      return Outcome::forbidden;
    case grpc::kResourceExhausted:
      if (says("space exceeded")) return Outcome::full;
      return says("too many requests") ? Outcome::unavailable : Outcome::invalid;
    case grpc::kUnavailable:
      // A member without a leader refuses before it takes the transaction.
      return says("no leader") ? Outcome::unavailable : Outcome::unsure;
    default:
      return Outcome::unsure;
  }
}

}  // namespace mlcca::cluster
