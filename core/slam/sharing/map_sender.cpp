// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/map_sender.hpp"

#include <algorithm>
#include <span>
#include <vector>

#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/map_closures.hpp"
#include "swiftlet/core/messages/submap_chunk.hpp"
#include "swiftlet/core/messages/submap_descriptor.hpp"
#include "swiftlet/core/messages/submap_places.hpp"
#include "swiftlet/core/messages/submap_request.hpp"

namespace swiftlet {
namespace {

// [-] Messages per step. Larger values take longer in a step.
constexpr int kMaxSent = 8;
// [B] Allowance required before any message is sent (token bucket): the size of the largest messages. Larger values
// delay small messages. With smaller ones, large messages exceed the data rate briefly.
constexpr double kLargestMessage_bytes = 1200.0;
// [s] Depth of the token bucket beyond one message, as time at the full data rate. Larger values allow longer bursts.
constexpr double kBurst_s = 0.1;

Eigen::Vector3f rotation_vector_of(const Pose& T) {
  return rotation_vector_rad(Eigen::Quaterniond(Matrix3(T.linear()))).cast<float>();
}

std::vector<std::uint8_t> bits_of(std::span<const std::uint8_t> flags) {
  std::vector<std::uint8_t> bits((flags.size() + 7) / 8, 0);
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] != 0) bits[i / 8] = static_cast<std::uint8_t>(bits[i / 8] | 1U << (i % 8));
  }
  return bits;
}

}  // namespace

void MapSender::step(TimeNs t, OwnMap& own, std::span<PeerMap> peers, Outbox& outbox) {
  const double rate_bytes_s = 1e3 / 8.0 * config_.budget_kbps;
  if (started_) allowance_bytes_ += rate_bytes_s * to_seconds(t - last_step_);
  allowance_bytes_ = std::min(allowance_bytes_, kLargestMessage_bytes + kBurst_s * rate_bytes_s);
  started_ = true;
  last_step_ = t;
  for (int i = 0; i < kMaxSent && allowance_bytes_ >= kLargestMessage_bytes; ++i) {
    if (!send_next(t, own, peers, outbox)) return;
    allowance_bytes_ -= static_cast<double>(outbox.messages().back().size_bytes());
  }
}

bool MapSender::send_next(TimeNs t, OwnMap& own, std::span<PeerMap> peers, Outbox& outbox) {
  const auto num = static_cast<VehicleId>(peers.size());
  for (VehicleId i = 0; i < num; ++i) {
    PeerMap& other = peers[static_cast<std::size_t>(i)];
    if (i != self_ && (send_request(t, i, other, outbox) || send_closures(t, i, other, outbox))) return true;
  }
  if (send_places(t, own, outbox) || send_descriptor(own, outbox)) return true;
  for (VehicleId i = 0; i < num; ++i) {  // round robin over vehicles
    const VehicleId to = (next_served_ + i) % num;
    if (!send_chunk(to, own, peers[static_cast<std::size_t>(to)], outbox)) continue;
    next_served_ = (to + 1) % num;
    return true;
  }
  return false;
}

bool MapSender::send_request(TimeNs t, VehicleId to, PeerMap& other, Outbox& outbox) const {
  if (!other.is_searched_here || !other.is_in_contact(t, kSilentReports * config_.report_interval_s)) return false;
  return send_cloud_request(t, to, other, outbox) || send_descriptor_request(t, to, other, outbox);
}

bool MapSender::send_cloud_request(TimeNs t, VehicleId to, PeerMap& other, Outbox& outbox) const {
  const bool due = !other.is_requested || to_seconds(t - other.requested) >= config_.retry_after_s;
  if (other.fetching < 0 || !due) return false;
  SubmapRequest request;
  std::vector<std::uint8_t> missing = other.submaps[static_cast<std::size_t>(other.fetching)].has_chunk;
  for (std::uint8_t& flag : missing) flag = flag == 0 ? 1 : 0;
  request.submap = static_cast<std::uint32_t>(other.fetching);
  request.missing = bits_of(missing);
  for (std::size_t i = 0; i < missing.size(); ++i) other.last_requested = missing[i] != 0 ? i : other.last_requested;
  other.is_requested = true;
  other.requested = t;
  write_message(request, outbox.add(to));
  return true;
}

bool MapSender::send_descriptor_request(TimeNs t, VehicleId to, PeerMap& other, Outbox& outbox) const {
  if (to_seconds(t - other.descriptors_requested) < config_.retry_after_s) return false;
  SubmapRequest request;
  std::vector<std::uint8_t> missing;
  for (std::uint32_t i = 0; i < other.num_finished; ++i) {
    const bool is_missing = i >= other.submaps.size() || !other.submaps[i].look;
    if (!is_missing && missing.empty()) continue;
    if (missing.empty()) request.submap = i;
    missing.push_back(is_missing ? 1 : 0);
  }
  other.descriptors_requested = t;
  if (missing.empty()) return false;
  request.content = SubmapRequest::Content::kDescriptors;
  request.missing = bits_of(missing);
  write_message(request, outbox.add(to));
  return true;
}

bool MapSender::send_closures(TimeNs t, VehicleId to, PeerMap& other, Outbox& outbox) const {
  if (!other.is_searched_here || other.closures.empty()) return false;
  if (!other.is_in_contact(t, kSilentReports * config_.report_interval_s)) return false;
  if (!other.closures_due && to_seconds(t - other.closures_sent) < config_.report_interval_s) return false;
  other.closures_due = false;
  other.closures_sent = t;
  MapClosures sent;
  for (const MapClosure& c : other.closures) {
    sent.closures.push_back({static_cast<std::uint32_t>(c.own), static_cast<std::uint32_t>(c.other),
                             c.T_own_other.translation().cast<float>(), rotation_vector_of(c.T_own_other)});
  }
  write_message(sent, outbox.add(to));
  return true;
}

bool MapSender::send_places(TimeNs t, OwnMap& own, Outbox& outbox) {
  const double since_s = to_seconds(t - places_sent_);
  if (own.places.empty() || since_s < (own.places_due ? kMinUpdateInterval_s : config_.report_interval_s)) return false;
  SubmapPlaces sent;
  sent.num_finished = static_cast<std::uint32_t>(own.submaps.size());
  if (next_place_ >= own.places.size()) next_place_ = 0;
  sent.first = static_cast<std::uint32_t>(next_place_);
  for (; next_place_ < own.places.size() && sent.places.size() < MapMessageLimits::kListed; ++next_place_) {
    const SubmapPlace& place = own.places[next_place_];
    sent.places.push_back({place.T_local_submap.translation().cast<float>(), rotation_vector_of(place.T_local_submap),
                           static_cast<float>(place.path_length_m)});
  }
  if (next_place_ >= own.places.size()) own.places_due = false;
  places_sent_ = t;
  write_message(sent, outbox.add());
  return true;
}

bool MapSender::send_descriptor(OwnMap& own, Outbox& outbox) const {
  const auto next =
      std::find_if(own.submaps.begin(), own.submaps.end(), [](const OwnSubmap& submap) { return submap.is_due; });
  if (next == own.submaps.end()) return false;
  next->is_due = false;
  SubmapDescriptor sent;
  sent.submap = static_cast<std::uint32_t>(next - own.submaps.begin());
  sent.num_points = next->num_points;
  sent.num_chunks = static_cast<std::uint16_t>(next->chunks.size());
  sent.directions = next->look.directions.quantized();
  sent.heights.assign(next->look.heights.begin(), next->look.heights.end());
  write_message(sent, outbox.add());
  return true;
}

bool MapSender::send_chunk(VehicleId to, const OwnMap& own, PeerMap& other, Outbox& outbox) const {
  if (other.requested_submap < 0) return false;
  const auto next = std::find(other.requested_chunks.begin(), other.requested_chunks.end(), 1);
  if (next == other.requested_chunks.end()) {
    other.requested_submap = -1;
    return false;
  }
  *next = 0;
  const auto number = static_cast<std::size_t>(next - other.requested_chunks.begin());
  const PackedPoints& chunk = own.submaps[static_cast<std::size_t>(other.requested_submap)].chunks[number];
  SubmapChunk sent;
  sent.submap = static_cast<std::uint32_t>(other.requested_submap);
  sent.chunk = static_cast<std::uint16_t>(number);
  sent.num_points = chunk.num_points;
  sent.bits = static_cast<std::uint16_t>(CompactCloudConfig::kBits);
  sent.voxel_m = static_cast<float>(config_.cloud.voxel_m);
  sent.data = chunk.data;
  write_message(sent, outbox.add(to));
  return true;
}

}  // namespace swiftlet
