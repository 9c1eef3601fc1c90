// SPDX-License-Identifier: BSD-3-Clause
#include "sim/run/state_hash.hpp"

#include "sim/run/hasher_internal.hpp"

namespace swiftlet::sim {

std::uint64_t hash_of(const Observation& observation) {
  Hasher h;
  Observation::each_samples(observation, [&h](const auto& samples) { h.list("", samples, ""); });
  std::vector<std::byte> bytes;
  for (const auto& samples : observation.others) {
    bytes.clear();
    samples->append_bytes(bytes);
    h.field("", bytes, "");
  }
  h.field("", observation.scans.size(), "");
  for (const auto& scan : observation.scans) Scan::visit(*scan, h);
  h.list("", observation.messages, "");
  return h.digest();
}

std::uint64_t hash_of(const Action& action) {
  Hasher h;
  Action::visit(action, h);
  return h.digest();
}

std::uint64_t hash_of(const VehicleState& state) {
  Hasher h;
  VehicleState::visit(state, h);
  return h.digest();
}

std::uint64_t combine(std::uint64_t hash, std::uint64_t value) {
  const std::uint64_t both[2] = {hash, value};
  return XXH3_64bits(both, sizeof both);
}

}  // namespace swiftlet::sim
