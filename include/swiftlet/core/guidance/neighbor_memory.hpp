// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"

namespace swiftlet {

/// Where a vehicle learns about its neighbors.
struct NeighborSourceConfig {
  enum class Source { kSensor, kRadio, kTracks, kNone };
  Source source = Source::kSensor;
  double timeout_s = 1.0;
  double acceleration_sigma_mps2 = 1.0;
  bool predict = true;

  void visit(ConfigVisitor& v);
};

/// Another vehicle as known now, in the own local frame.
struct Neighbor {
  std::int64_t key = 0;  ///< identity at its source
  Vector3 position_local_m = Vector3::Zero();
  Vector3 velocity_local_mps = Vector3::Zero();
  TimeNs seen = 0;  ///< time of validity of the last measurement
};

/// Keeps the neighbors of a mutual-localization sensor, of radio messages, or of tracks. Each has a Kalman filter of
/// constant velocity, and is forgotten when it was not heard of for a while.
class NeighborMemory {
 public:
  explicit NeighborMemory(const NeighborSourceConfig& config) : config_(config) {}

  void update(const GuidanceInput& input);
  /// Everybody not forgotten, in order of keys.
  std::span<const Neighbor> neighbors() const { return known_; }

  /// What to say to the neighbors when they listen to the radio (source: radio), once a call.
  void announce(const StateEstimate& estimate, Outbox& outbox) const;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  struct Filter {
    std::int64_t key = 0;
    TimeNs t = 0;  // of the state
    TimeNs seen = 0;
    Vector6 x = Vector6::Zero();
    Matrix6 P = Matrix6::Identity();
  };

  void measure(std::int64_t key, TimeNs t, const Vector3& position_local_m, const Matrix3& covariance);
  void hear(const Message& message, const FrameChange& to_local);
  void predict(Filter& filter, TimeNs t) const;

  NeighborSourceConfig config_;
  std::vector<Filter> filters_;
  std::vector<Neighbor> known_;
};

}  // namespace swiftlet
