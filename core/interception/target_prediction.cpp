// SPDX-License-Identifier: BSD-3-Clause
#include "core/interception/target_prediction.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/tracking/motion_filter.hpp"

namespace swiftlet {
namespace {

PointState straight(const Vector9& mean, double t_s) {
  const Vector3 v_mps = mean.segment<3>(3);
  return {mean.head<3>() + t_s * v_mps, v_mps, Vector3::Zero()};
}

/// The acceleration decays as exp(-t / T) (Singer, IEEE TAES 6(4), 1970).
PointState fading(const Vector9& mean, double t_s, double T_s) {
  const Vector3 v_mps = mean.segment<3>(3), a_mps2 = mean.tail<3>();
  const double gained_s = T_s * (1.0 - elementary::exp(-t_s / T_s));
  return {mean.head<3>() + t_s * v_mps + T_s * (t_s - gained_s) * a_mps2, v_mps + gained_s * a_mps2, Vector3::Zero()};
}

PointState turning(const Vector9& mean, double t_s) {
  const Vector9 then = coordinated_turn_transition(t_s, turn_rate_radps(mean)) * mean;
  return {then.head<3>(), then.segment<3>(3), Vector3::Zero()};
}

}  // namespace

void TargetPredictionConfig::visit(ConfigVisitor& v) {
  v.field("acceleration_time_s", acceleration_time_s, "[s] time constant of the decay of an acceleration",
          Range::positive());
  v.field("speed_max_mps", speed_max_mps, "[m/s] upper limit of a predicted speed", Range::positive());
}

TargetPrediction::TargetPrediction(const TargetPredictionConfig& config, const Track& track, const TrackModes* modes,
                                   TimeNs now)
    : config_(config), covariance_(track.covariance), age_s_(to_seconds(now - track.t)) {
  if (modes != nullptr) {
    modes_ = *modes;
    return;
  }
  modes_.probability = {0.0, 1.0, 0.0};
  modes_.mean_local_m.fill(Vector9::Zero());
  modes_.mean_local_m[TrackModes::kConstantAcceleration] << track.position_m, track.velocity_mps,
      track.acceleration_mps2;
}

PointState TargetPrediction::at(double ahead_s) const {
  const double t_s = age_s_ + ahead_s;
  PointState mixture;
  for (std::size_t m = 0; m < TrackModes::kModels; ++m) {
    const double probability = modes_.probability[m];
    if (probability <= 0.0) continue;
    const Vector9& mean = modes_.mean_local_m[m];
    PointState part = m == TrackModes::kConstantVelocity       ? straight(mean, t_s)
                      : m == TrackModes::kConstantAcceleration ? fading(mean, t_s, config_.acceleration_time_s)
                                                               : turning(mean, t_s);
    mixture.p_m += probability * part.p_m;
    mixture.v_mps += probability * part.v_mps;
  }
  const double speed_mps = mixture.v_mps.norm();
  if (speed_mps > config_.speed_max_mps) mixture.v_mps *= config_.speed_max_mps / speed_mps;
  return mixture;
}

double TargetPrediction::sigma_m(double ahead_s) const {
  const double t_s = age_s_ + ahead_s;
  const Matrix3 C = covariance_.topLeftCorner<3, 3>() + t_s * covariance_.block<3, 3>(0, 3) +
                    t_s * covariance_.block<3, 3>(3, 0) + t_s * t_s * covariance_.block<3, 3>(3, 3);
  return std::sqrt(std::max(0.0, C.diagonal().maxCoeff()));
}

}  // namespace swiftlet
