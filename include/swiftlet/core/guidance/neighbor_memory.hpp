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
  double timeout_s = 10.0;
  double acceleration_sigma_mps2 = 2.0;
  double first_speed_sigma_mps = 2.0;
  double unseen_speed_mps = 0.5;
  bool remember_hidden = true;
  bool predict = true;

  /// Who was not measured for a second is gone, as flocking models have it.
  static NeighborSourceConfig forgetful();
  void visit(ConfigVisitor& v);
};

/// Another vehicle as known now, in the own local frame.
struct Neighbor {
  std::int64_t key = 0;  ///< identity at its source
  Vector3 position_local_m = Vector3::Zero();
  Vector3 velocity_local_mps = Vector3::Zero();
  TimeNs seen = 0;                                            ///< time of validity of the last measurement
  Matrix3 covariance_local_m2 = Matrix3::Zero();              ///< of the position
  Matrix3 velocity_covariance_local_m2ps2 = Matrix3::Zero();  ///< of the velocity
  double unpredicted_s = 0.0;                                 ///< since the time up to which it was carried forward
  bool in_view = true;                                        ///< could be seen from here
  Vector3 seen_local_m = Vector3::Zero();                     ///< where it was at the last measurement
  Matrix3 seen_covariance_local_m2 = Matrix3::Zero();         ///< of that place
  Vector3 own_seen_local_m = Vector3::Zero();                 ///< where the own vehicle was then
};

/// Keeps the neighbors of a mutual-localization sensor, of radio messages, or of tracks. Each has a Kalman filter of
/// constant velocity. It is forgotten when it was not measured for a while although the sensor looked there: one in the
/// blind sector is still there. One beyond the range is no other than those that were never seen.
class NeighborMemory {
 public:
  /// @param views  of the sensors; none: all around
  explicit NeighborMemory(const NeighborSourceConfig& config, std::vector<NeighborView> views = {})
      : config_(config), views_(std::move(views)) {}

  void update(const GuidanceInput& input);
  /// Everybody not forgotten, in order of keys, as of the last update. They are carried forward when they are asked
  /// for.
  std::span<const Neighbor> neighbors();

  /// How late samples come, and how far apart those of one neighbor are: at least, and at most of late. As seen so far;
  /// 0: not yet. A neighbor that should be in view and is not measured counts as it is.
  double latency_s() const { return latency_s_; }
  double shortest_s() const { return shortest_s_; }
  double longest_s() const { return longest_s_; }

  /// What to say to the neighbors when they listen to the radio (source: radio), once a call.
  void announce(const StateEstimate& estimate, Outbox& outbox) const;

 private:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  struct Filter {
    std::int64_t key = 0;
    TimeNs t = 0;  // of the state
    TimeNs seen = 0;
    TimeNs missed = 0;                      ///< for how long it was in view since then, unseen
    TimeNs sought = 0;                      ///< the same with those times at which it was beyond the range
    bool in_view = true;                    ///< at the last update
    bool looked_at = true;                  ///< at the last update
    Vector3 own_local_m = Vector3::Zero();  ///< of the own vehicle when it was seen
    Vector6 x = Vector6::Zero();
    Matrix6 P = Matrix6::Identity();
  };

  void measure(std::int64_t key, TimeNs t, const Vector3& position_local_m, const Matrix3& covariance,
               const Vector3& own_local_m);
  void hear(const Message& message, const GuidanceInput& input);
  void predict(Filter& filter, TimeNs t) const;

  Neighbor now_of(const Filter& filter) const;
  Vector3 position_now_local_m(const Filter& filter) const;
  void forget(TimeNs now);
  bool is_any(bool (NeighborView::*sees)(const Vector3&) const, const Vector3& p_body_m) const;

  NeighborSourceConfig config_;
  std::vector<NeighborView> views_;
  TimeNs last_ = -1;  ///< update; negative: there was none
  TimeNs now_ = 0;
  double latency_s_ = 0.0, shortest_s_ = 0.0, longest_s_ = 0.0;
  std::vector<Filter> filters_;  ///< in order of keys
  std::vector<Neighbor> known_;
  bool to_carry_ = false;  ///< the filters have changed since
};

}  // namespace swiftlet
