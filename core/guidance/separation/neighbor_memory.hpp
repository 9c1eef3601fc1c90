// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "swiftlet/core/guidance/guidance.hpp"
#include "swiftlet/core/guidance/neighbor_source.hpp"

namespace swiftlet {

/// State of another vehicle, predicted to now, in the own local frame.
struct Neighbor {
  std::int64_t key = 0;  ///< identity at the source
  Vector3 position_local_m = Vector3::Zero();
  Vector3 velocity_local_mps = Vector3::Zero();
  TimeNs seen = 0;                                            ///< validity time of the last measurement
  Matrix3 covariance_local_m2 = Matrix3::Zero();              ///< covariance of the position
  Matrix3 velocity_covariance_local_m2ps2 = Matrix3::Zero();  ///< covariance of the velocity
  double unpredicted_s = 0.0;                          ///< time since the end of the prediction, which is limited
  bool in_view = true;                                 ///< inside the field of view and range of a sensor
  Vector3 seen_local_m = Vector3::Zero();              ///< position at the last measurement
  Matrix3 seen_covariance_local_m2 = Matrix3::Zero();  ///< covariance of seen_local_m
  Vector3 own_seen_local_m = Vector3::Zero();          ///< position of the own vehicle at that time
};

/// Timing of the samples of neighbors so far; 0: no sample yet.
struct SampleTiming {
  double latency_s = 0.0;   ///< largest latency
  double shortest_s = 0.0;  ///< shortest interval between two samples of one neighbor
  double longest_s = 0.0;   ///< longest recent interval; a running gap of a neighbor in view counts too
};

/// Tracks the neighbors of a mutual-localization sensor, of radio messages, or of tracks, each by a Kalman filter with
/// constant velocity. A neighbor is dropped when it is unseen for timeout_s inside the sensor's field of view; time in
/// the blind sector does not count. Beyond the range a neighbor is like an undetected vehicle, so that time counts.
class NeighborMemory {
 public:
  /// @param views  fields of view of the sensors; empty: omnidirectional
  explicit NeighborMemory(const NeighborSourceConfig& config, std::vector<NeighborView> views = {})
      : config_(config), views_(std::move(views)) {}

  void update(const GuidanceInput& input);
  /// Neighbors in order of keys, as of the last update. The prediction to now is computed on the first call.
  std::span<const Neighbor> neighbors();

  const SampleTiming& timing() const { return timing_; }

  /// Broadcasts the own position when the source is the radio; once per call.
  void announce(const StateEstimate& estimate, Outbox& outbox) const;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  struct Filter {
    std::int64_t key = 0;
    TimeNs t = 0;  // time of the state
    TimeNs seen = 0;
    TimeNs missed = 0;          ///< time in view since the last measurement
    TimeNs unseen_in_view = 0;  ///< time in the field of view since the last measurement, including beyond the range
    bool in_view = true;        ///< at the last update
    bool looked_at = true;      ///< at the last update
    Vector3 own_local_m = Vector3::Zero();  ///< position of the own vehicle at the last measurement
    Vector6 x = Vector6::Zero();
    Matrix6 P = Matrix6::Identity();
  };

  void measure(std::int64_t key, TimeNs t, const Vector3& position_local_m, const Matrix3& covariance,
               const Vector3& own_local_m);
  void receive(const Message& message, const GuidanceInput& input);
  void predict(Filter& filter, TimeNs t) const;

  Neighbor now_of(const Filter& filter) const;
  Vector3 position_now_local_m(const Filter& filter) const;
  void forget(TimeNs now);
  bool is_any(bool (NeighborView::*sees)(const Vector3&) const, const Vector3& p_body_m) const;

  NeighborSourceConfig config_;
  std::vector<NeighborView> views_;
  TimeNs last_ = -1;  ///< time of the last update; negative: none yet
  TimeNs now_ = 0;
  SampleTiming timing_;
  std::vector<Filter> filters_;  ///< in order of keys
  std::vector<Neighbor> known_;
  bool to_carry_ = false;  ///< the filters have changed since the last prediction
};

}  // namespace swiftlet
