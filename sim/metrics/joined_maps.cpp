// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <numbers>

#include "sim/metrics/statistics.hpp"
#include "swiftlet/core/base/time.hpp"
#include "swiftlet/core/messages/map_closures.hpp"
#include "swiftlet/core/messages/submap_chunk.hpp"
#include "swiftlet/core/messages/submap_descriptor.hpp"
#include "swiftlet/core/messages/submap_places.hpp"
#include "swiftlet/core/messages/submap_request.hpp"
#include "swiftlet/core/slam/joined_map.hpp"
#include "swiftlet/sim/metrics/metric.hpp"

namespace swiftlet::sim {
namespace {

// Reported metrics:
constexpr MetricDefinition kJoinedAt = {"joined_s", "s",
                                        "time at which the map was first joined with that of another vehicle"};
constexpr MetricDefinition kJoinedRmse = {
    "joined_position_rmse_m", "m",
    "root mean square of |estimated - true position of another vehicle|, computed from the joined local frames, "
    "relative to the own body, over the ticks with joined maps"};
constexpr MetricDefinition kJoinedMax = {"joined_position_max_m", "m", "greatest of these errors"};
constexpr MetricDefinition kJoinedEnd = {"joined_position_end_m", "m", "error in the last of these ticks"};
constexpr MetricDefinition kJoinedYawRmse = {
    "joined_yaw_rmse_rad", "rad", "root mean square error of that vehicle's heading relative to the own one"};
constexpr MetricDefinition kJoinedYawEnd = {"joined_yaw_end_rad", "rad", "error in the last of these ticks"};
constexpr MetricDefinition kJoinedNees = {"joined_nees", "",
                                          "mean normalized error squared of the position; 3 for correct covariances"};
constexpr MetricDefinition kLooksSent = {"map_looks_bytes", "B", "sent descriptors of submaps, with headers"};
constexpr MetricDefinition kCloudsSent = {"map_clouds_bytes", "B", "sent clouds of submaps, with headers"};
constexpr MetricDefinition kMessagesSent = {
    "map_words_bytes", "B", "all other sent messages about maps: positions, requests and closures, with headers"};
constexpr MetricDefinition kJoinedMapsDefinitions[] = {kJoinedAt,      kJoinedRmse,   kJoinedMax,  kJoinedEnd,
                                                       kJoinedYawRmse, kJoinedYawEnd, kJoinedNees, kLooksSent,
                                                       kCloudsSent,    kMessagesSent};

/// Error of the transform between the local frames of two vehicles, as estimated by one of them. The true local frame
/// is the one in which the vehicle's own estimate is exact at that instant.
class JoinedMapsMetric final : public Metric {
 public:
  explicit JoinedMapsMetric(const MetricSetup& setup) : Metric(setup), vehicles_(num_vehicles()) {}

  void update(const TickView& tick, const MetricContext&) override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      count_messages(tick.actions[i]->messages, vehicles_[i]);
      if (tick.agents.empty() || tick.states[i].crashed || !tick.actions[i]->estimate.valid) continue;
      const auto* joins = dynamic_cast<const JoinedMapProvider*>(tick.agents[i].get());
      if (joins == nullptr) continue;
      for (const JoinedMap& joined : joins->joined_maps()) score(tick, i, joined);
    }
  }

  void report(MetricTable& table) const override {
    for (std::size_t i = 0; i < num_vehicles(); ++i) {
      const Vehicle& vehicle = vehicles_[i];
      if (vehicle.looks_bytes + vehicle.clouds_bytes + vehicle.words_bytes == 0 && vehicle.count == 0) continue;
      table.add(kJoinedAt, name_of(i), vehicle.joined_s);
      table.add(kJoinedRmse, name_of(i), vehicle.position.rms());
      table.add(kJoinedMax, name_of(i), vehicle.position.max());
      table.add(kJoinedEnd, name_of(i), vehicle.end_m);
      table.add(kJoinedYawRmse, name_of(i), vehicle.yaw.rms());
      table.add(kJoinedYawEnd, name_of(i), vehicle.end_rad);
      table.add(kJoinedNees, name_of(i),
                vehicle.count > 0 ? vehicle.nees_sum / static_cast<double>(vehicle.count) : kNotMeasured);
      table.add(kLooksSent, name_of(i), static_cast<double>(vehicle.looks_bytes));
      table.add(kCloudsSent, name_of(i), static_cast<double>(vehicle.clouds_bytes));
      table.add(kMessagesSent, name_of(i), static_cast<double>(vehicle.words_bytes));
    }
  }

 private:
  struct Vehicle {
    double joined_s = kNotMeasured, end_m = kNotMeasured, end_rad = kNotMeasured;
    ErrorStatistics position, yaw;
    double nees_sum = 0.0;
    std::uint64_t count = 0;
    std::size_t looks_bytes = 0, clouds_bytes = 0, words_bytes = 0;
  };

  static void count_messages(const std::vector<Message>& messages, Vehicle& vehicle) {
    for (const Message& message : messages) {
      if (message.topic == SubmapDescriptor::kTopic)
        vehicle.looks_bytes += message.size_bytes();
      else if (message.topic == SubmapChunk::kTopic)
        vehicle.clouds_bytes += message.size_bytes();
      else if (message.topic == SubmapPlaces::kTopic || message.topic == SubmapRequest::kTopic ||
               message.topic == MapClosures::kTopic)
        vehicle.words_bytes += message.size_bytes();
    }
  }

  void score(const TickView& tick, std::size_t i, const JoinedMap& joined) {
    const auto other = static_cast<std::size_t>(joined.other);
    if (tick.states[other].crashed || !tick.actions[other]->estimate.valid) return;
    const Pose& T_local_body = tick.actions[i]->estimate.T_local_body;
    const Pose T_joined = joined.T_local_otherlocal * tick.actions[other]->estimate.T_local_body;
    const Pose T_true = T_local_body * tick.states[i].T_world_body().inverse() * tick.states[other].T_world_body();
    const Vector3 off_m = T_joined.translation() - T_true.translation();
    const double off_rad = std::remainder(yaw_of(T_joined.linear()) - yaw_of(T_true.linear()), 2.0 * std::numbers::pi);
    Vehicle& vehicle = vehicles_[i];
    if (vehicle.count++ == 0) vehicle.joined_s = to_seconds(tick.t);
    vehicle.position.add(off_m.norm());
    vehicle.yaw.add(off_rad);
    vehicle.end_m = off_m.norm();
    vehicle.end_rad = std::abs(off_rad);
    const Matrix3 C = joined.covariance.topLeftCorner<3, 3>();
    vehicle.nees_sum += off_m.dot(C.ldlt().solve(off_m));
  }

  std::vector<Vehicle> vehicles_;
};

}  // namespace

MetricType joined_maps_metric() {
  return {"joined_maps", "maps of SLAM joined by radio, against truth", make_metric<JoinedMapsMetric>,
          kJoinedMapsDefinitions};
}

}  // namespace swiftlet::sim
