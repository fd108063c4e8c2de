// SPDX-License-Identifier: BSD-2-Clause
// The peer of admissions: Cyclone DDS matching as many readers and writers, each pair on a topic of
// its own, with a deadline that the match depends on. One participant, one process, no network
// between.
#include <dds/dds.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "bench/dds/pair.h"

namespace {

void expect(bool good, const char* what) {
  if (good) return;
  std::fprintf(stderr, "dds_peer: %s\n", what);
  std::exit(1);
}

bool is_matched(dds_entity_t writer) {
  dds_publication_matched_status_t status;
  return dds_get_publication_matched_status(writer, &status) == DDS_RETCODE_OK &&
         status.current_count == 1;
}

}  // namespace

/// dds_peer PAIRS: prints the pairs that were matched in a second.
int main(int argc, char** argv) {
  const int pairs = argc > 1 ? std::atoi(argv[1]) : 1000;
  const dds_entity_t participant = dds_create_participant(DDS_DOMAIN_DEFAULT, nullptr, nullptr);
  expect(participant > 0, "no participant");
  const std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)> qos(dds_create_qos(), dds_delete_qos);
  dds_qset_deadline(qos.get(), DDS_MSECS(50));
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  std::vector<dds_entity_t> writers;
  writers.reserve(static_cast<std::size_t>(pairs));
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < pairs; ++i) {
    const std::string name = "channel" + std::to_string(i);
    const dds_entity_t topic =
        dds_create_topic(participant, &pair_Event_desc, name.c_str(), nullptr, nullptr);
    expect(topic > 0, "no topic");
    expect(dds_create_reader(participant, topic, qos.get(), nullptr) > 0, "no reader");
    writers.push_back(dds_create_writer(participant, topic, qos.get(), nullptr));
    expect(writers.back() > 0, "no writer");
  }
  for (const dds_entity_t writer : writers)
    while (!is_matched(writer)) dds_sleepfor(DDS_USECS(100));
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  std::printf("%.0f\n", pairs / taken.count());
  dds_delete(participant);
  return 0;
}
