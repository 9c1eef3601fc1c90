// SPDX-License-Identifier: BSD-3-Clause
#include "core/slam/sharing/map_receiver.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "swiftlet/core/localization/dead_reckoning.hpp"
#include "swiftlet/core/localization/rotation.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/map_closures.hpp"
#include "swiftlet/core/messages/submap_chunk.hpp"
#include "swiftlet/core/messages/submap_descriptor.hpp"
#include "swiftlet/core/messages/submap_places.hpp"
#include "swiftlet/core/messages/submap_request.hpp"

namespace swiftlet {
namespace {

using Limits = MapMessageLimits;

/// The received pose, or none if it is implausible.
std::optional<Pose> received_pose(const Eigen::Vector3f& p_m, const Eigen::Vector3f& turn_rad, double farthest_m) {
  if (!p_m.allFinite() || !turn_rad.allFinite()) return std::nullopt;
  if (p_m.cwiseAbs().maxCoeff() > farthest_m || turn_rad.norm() > kPi + Limits::kTurnMargin_rad) return std::nullopt;
  const Pose T = make_pose(p_m.cast<double>(), rotation_by(turn_rad.cast<double>()));
  if (T.linear()(2, 2) < Limits::kMinTiltCosine) return std::nullopt;
  return T;
}

bool bit_at(std::span<const std::uint8_t> bits, std::size_t i) { return (bits[i / 8] >> (i % 8) & 1U) != 0; }

bool is_same(const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); }

bool receive_places(TimeNs t, const Message& message, PeerMap& from) {
  SubmapPlaces received;
  if (read_message(message, received) != Reading::kDone) return false;
  const std::size_t end = received.first + received.places.size();
  if (received.num_finished >= Limits::kSubmaps || received.places.size() > Limits::kListed ||
      end > std::size_t{received.num_finished} + 1) {
    return false;
  }
  std::vector<SubmapPlace> places;
  for (const SubmapPlaces::Place& place : received.places) {
    const std::optional<Pose> T = received_pose(place.p_local_m, place.turn_local_rad, Limits::kDistance_m);
    if (!T || !(place.path_length_m >= 0.0F && place.path_length_m <= static_cast<float>(Limits::kPathLength_m)))
      return false;
    places.push_back({true, *T, static_cast<double>(place.path_length_m)});
  }
  if (from.places.size() < end) from.places.resize(end);
  for (std::size_t i = 0; i < places.size(); ++i) {
    SubmapPlace& known = from.places[received.first + i];
    from.needs_consistency_test =
        from.needs_consistency_test || !known.known || !is_same(known.T_local_submap, places[i].T_local_submap);
    known = places[i];
  }
  if (received.num_finished > from.num_finished) {
    from.num_finished = received.num_finished;
    from.descriptors_requested = t;  // postpones the request: the descriptors of new submaps are in transit
  }
  return true;
}

PeerSubmap& submap_of(PeerMap& from, std::uint32_t number) {
  if (from.submaps.size() <= number) from.submaps.resize(number + 1);
  return from.submaps[number];
}

bool receive_descriptor(const Message& message, const OwnMap& own, PeerMap& from) {
  SubmapDescriptor received;
  if (read_message(message, received) != Reading::kDone) return false;
  if (received.submap >= Limits::kSubmaps || received.num_chunks > Limits::kChunks ||
      received.num_points > Limits::kPoints)
    return false;
  std::optional<SubmapLook> look = SubmapLook::from_quantized(received.directions, received.heights);
  if (!look) return false;
  PeerSubmap& peer_submap = submap_of(from, received.submap);
  if (peer_submap.look) return true;
  peer_submap.look = std::move(look);
  peer_submap.num_points = received.num_points;
  peer_submap.has_chunk.assign(received.num_chunks, 0);
  for (const OwnSubmap& submap : own.submaps)
    peer_submap.similarity = std::max(peer_submap.similarity, likeness(submap.look, *peer_submap.look));
  return true;
}

bool receive_request(const Message& message, OwnMap& own, PeerMap& from) {
  SubmapRequest requested;
  if (read_message(message, requested) != Reading::kDone || requested.submap >= own.submaps.size()) return false;
  if (requested.content == SubmapRequest::Content::kDescriptors) {
    if (requested.missing.size() > (Limits::kSubmaps + 7) / 8) return false;
    for (std::size_t i = 0; i < 8 * requested.missing.size() && requested.submap + i < own.submaps.size(); ++i) {
      if (bit_at(requested.missing, i)) own.submaps[requested.submap + i].is_due = true;
    }
    return true;
  }
  const std::size_t num_chunks = own.submaps[requested.submap].chunks.size();
  if (num_chunks == 0 || requested.missing.size() != (num_chunks + 7) / 8) return false;
  from.requested_submap = static_cast<int>(requested.submap);
  from.requested_chunks.assign(num_chunks, 0);
  for (std::size_t i = 0; i < num_chunks; ++i) from.requested_chunks[i] = bit_at(requested.missing, i) ? 1 : 0;
  return true;
}

bool receive_chunk(TimeNs t, const Message& message, PeerMap& from) {
  SubmapChunk received;
  if (read_message(message, received) != Reading::kDone || received.submap >= from.submaps.size()) return false;
  PeerSubmap& peer_submap = from.submaps[received.submap];
  if (peer_submap.complete) return true;  // a repeated chunk
  if (static_cast<int>(received.submap) != from.fetching || received.chunk >= peer_submap.has_chunk.size())
    return false;
  if (!(received.voxel_m >= Limits::kMinVoxel_m && received.voxel_m <= Limits::kMaxVoxel_m)) return false;
  if (peer_submap.has_chunk[received.chunk] != 0) return true;
  if (peer_submap.points_submap_m.size() + received.num_points > peer_submap.num_points) return false;
  if (!unpack_points(received.data, received.num_points, static_cast<double>(received.voxel_m), received.bits,
                     peer_submap.points_submap_m)) {
    return false;
  }
  peer_submap.has_chunk[received.chunk] = 1;
  from.requested = t;  // restarts the retry timeout: the transfer is in progress
  peer_submap.complete = std::all_of(peer_submap.has_chunk.begin(), peer_submap.has_chunk.end(),
                                     [](std::uint8_t has) { return has != 0; });
  if (peer_submap.complete) from.fetching = -1;
  if (received.chunk >= from.last_requested)
    from.is_requested = false;  // chunks arrive in order: chunks missing now were lost
  return true;
}

bool receive_closures(const Message& message, const OwnMap& own, PeerMap& from) {
  if (from.is_searched_here) return false;
  MapClosures received;
  if (read_message(message, received) != Reading::kDone || received.closures.size() > Limits::kListed) return false;
  std::vector<MapClosure> closures;
  for (const MapClosures::Closure& c : received.closures) {
    const std::optional<Pose> T = received_pose(c.p_own_m, c.turn_own_rad, Limits::kInSubmap_m);
    if (!T || c.own >= Limits::kSubmaps || c.other >= own.submaps.size()) return false;
    closures.push_back({static_cast<int>(c.other), static_cast<int>(c.own), T->inverse()});
  }
  const auto same = [](const MapClosure& a, const MapClosure& b) {
    return a.own == b.own && a.other == b.other && is_same(a.T_own_other, b.T_own_other);
  };
  if (std::equal(closures.begin(), closures.end(), from.closures.begin(), from.closures.end(), same)) return true;
  from.closures = std::move(closures);
  from.needs_consistency_test = true;
  return true;
}

}  // namespace

bool is_map_topic(const std::string& topic) {
  return topic == SubmapDescriptor::kTopic || topic == SubmapPlaces::kTopic || topic == SubmapRequest::kTopic ||
         topic == SubmapChunk::kTopic || topic == MapClosures::kTopic;
}

bool receive_map_message(TimeNs t, const Message& message, OwnMap& own, PeerMap& from) {
  const bool is_valid = message.topic == SubmapPlaces::kTopic       ? receive_places(t, message, from)
                        : message.topic == SubmapDescriptor::kTopic ? receive_descriptor(message, own, from)
                        : message.topic == SubmapRequest::kTopic    ? receive_request(message, own, from)
                        : message.topic == SubmapChunk::kTopic      ? receive_chunk(t, message, from)
                                                                    : receive_closures(message, own, from);
  if (!is_valid) return false;
  from.last_report = t;
  from.has_reported = true;
  return true;
}

}  // namespace swiftlet
