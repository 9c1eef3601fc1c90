// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/gnss.hpp"

#include <algorithm>

#include "sim/sensors/noise.hpp"
#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {

void GnssConfig::visit(ConfigVisitor& v) {
  v.model("model", model, "sensors", "preset: gnss_m8p, gnss_rtk, gnss_mrs");
  visit_common(v);
  v.field("rate_hz", rate_hz, "[Hz] fixes per second", Range::between(1e-3, 1e5));
  v.field("position_m", position_m, "[m] position of the antenna, body frame");
  v.field("sigma_xy_m", sigma_xy_m, "[m] white noise of east and north", Range::non_negative());
  v.field("sigma_z_m", sigma_z_m, "[m] white noise of the altitude", Range::non_negative());
  v.field("drift_sigma_xy_m", drift_sigma_xy_m, "[m] standard deviation of the slow error of east and north",
          Range::non_negative());
  v.field("drift_sigma_z_m", drift_sigma_z_m, "[m] standard deviation of the slow error of the altitude",
          Range::non_negative());
  v.field("drift_time_s", drift_time_s, "[s] correlation time of the slow error", Range::positive());
  v.field("altitude_walk_m_psqrts", altitude_walk_m_psqrts,
          "[m/sqrt(s)] random walk of the altitude, from 0 at the start", Range::non_negative());
  v.field("sigma_velocity_xy_mps", sigma_velocity_xy_mps, "[m/s] white noise of the horizontal velocity",
          Range::non_negative());
  v.field("sigma_velocity_z_mps", sigma_velocity_z_mps, "[m/s] white noise of the vertical velocity",
          Range::non_negative());
  v.list("outages", outages, "times without a fix");
  v.field("random_outages_per_min", random_outages_per_min, "[1/min] rate of random outages while there is a fix",
          Range::non_negative());
  v.field("random_outage_mean_s", random_outage_mean_s, "[s] mean length of a random outage (exponential)",
          Range::positive());
  v.field("sky_view", sky_view, "[-] whether surfaces of the static world block satellites");
  v.field("num_satellites", num_satellites, "[-] number of satellites above the elevation mask", Range::between(4, 64));
  v.field("elevation_mask_deg", elevation_mask_deg, "[deg] elevation mask: least elevation of the satellites",
          Range::between(0.0, 80.0));
  v.field("multipath_sigma_m", multipath_sigma_m,
          "[m] standard deviation of multipath per axis when all satellites are blocked", Range::non_negative());
}

namespace {

constexpr double kSkyRange_m = 500.0;  // obstacles farther away do not block satellites
// [-] Fewest visible satellites of a fix: position and clock are four unknowns.
constexpr int kMinSatellites = 4;
// [s] Correlation time of multipath. Larger values keep an error longer.
constexpr double kMultipathTime_s = 10.0;

/// Directions spread evenly over the sky above the mask: equal areas in elevation, golden angle in azimuth.
std::vector<Vector3> constellation(int count, double mask_rad, double first_azimuth_rad) {
  const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0));
  const double lowest = elementary::sin(mask_rad);
  std::vector<Vector3> directions;
  for (int i = 0; i < count; ++i) {
    const double z = lowest + (1.0 - lowest) * (i + 0.5) / count;
    const double azimuth = first_azimuth_rad + i * golden_angle;
    const double horizontal = std::sqrt(1.0 - z * z);
    directions.emplace_back(horizontal * elementary::cos(azimuth), horizontal * elementary::sin(azimuth), z);
  }
  return directions;
}

/// Alternating exponentially distributed times with and without fixes. Queries must be in order of time.
class RandomOutages {
 public:
  RandomOutages(Random random, double rate_per_min, double mean_s)
      : random_(random), mean_up_s_(rate_per_min > 0.0 ? 60.0 / rate_per_min : 0.0), mean_down_s_(mean_s) {
    if (mean_up_s_ > 0.0) change_ = exponential(mean_up_s_);
  }

  bool active(TimeNs t) {
    if (mean_up_s_ <= 0.0) return false;
    while (t >= change_) {
      down_ = !down_;
      change_ += exponential(down_ ? mean_down_s_ : mean_up_s_);
    }
    return down_;
  }

 private:
  TimeNs exponential(double mean_s) {
    return std::max<TimeNs>(1, from_seconds(-mean_s * elementary::log(1.0 - random_.uniform(num_drawn_++, 0))));
  }

  Random random_;
  double mean_up_s_, mean_down_s_;
  std::uint32_t num_drawn_ = 0;
  TimeNs change_ = 0;
  bool down_ = false;
};

class GnssSensor final : public Sensor {
 public:
  GnssSensor(const GnssConfig& config, SensorSetup setup)
      : Sensor(std::move(setup)),
        config_(config),
        schedule_(config.rate_hz),
        white_(stream("gnss.white")),
        velocity_(stream("gnss.velocity")),
        drift_noise_(stream("gnss.drift")),
        altitude_noise_(stream("gnss.altitude")),
        multipath_noise_(stream("gnss.multipath")),
        drift_(GaussMarkov::stationary(drift_sigma(), config.drift_time_s, normal3(stream("gnss.drift.start"), 0))),
        altitude_(GaussMarkov::walking({0.0, 0.0, config.altitude_walk_m_psqrts}, 0.0)),
        multipath_(
            GaussMarkov::stationary(Vector3::Ones(), kMultipathTime_s, normal3(stream("gnss.multipath.start"), 0))),
        random_outages_(stream("gnss.outage"), config.random_outages_per_min, config.random_outage_mean_s),
        satellites_(constellation(config.num_satellites, config.elevation_mask_deg * kRadPerDeg,
                                  stream("gnss.satellites").uniform(0.0, 2.0 * std::numbers::pi, 0, 0))) {}

  void measure(TimeNs now, const StateHistory& truth, Observation& out) override {
    TimeNs due = 0;
    std::uint32_t index = 0;
    while (schedule_.next(now, due, index)) {
      advance_errors(index);
      const VehicleState state = truth.at(setup_.vehicle, due);
      const Vector3 p_world_antenna = state.p_world_m + state.q_world_body * config_.position_m;
      const int num_visible = visible_satellites(p_world_antenna);
      if (in_outage(due) || num_visible < kMinSatellites) continue;
      out.gnss.push_back(fix(due, index, state, p_world_antenna, num_visible));
    }
  }

 private:
  Vector3 white_sigma() const { return {config_.sigma_xy_m, config_.sigma_xy_m, config_.sigma_z_m}; }
  Vector3 drift_sigma() const { return {config_.drift_sigma_xy_m, config_.drift_sigma_xy_m, config_.drift_sigma_z_m}; }

  // Slow errors continue during outages.
  void advance_errors(std::uint32_t index) {
    if (index == 0) return;
    const double dt_s = to_seconds(schedule_.period());
    drift_.advance(dt_s, normal3(drift_noise_, index));
    altitude_.advance(dt_s, normal3(altitude_noise_, index));
    multipath_.advance(dt_s, normal3(multipath_noise_, index));
  }

  bool in_outage(TimeNs t) {
    const bool is_random = random_outages_.active(t);
    return is_random || std::ranges::any_of(config_.outages, [t](const OutageConfig& o) { return o.contains(t); });
  }

  int visible_satellites(const Vector3& p_world_antenna) const {
    if (!config_.sky_view || !setup_.world) return config_.num_satellites;
    return static_cast<int>(std::count_if(satellites_.begin(), satellites_.end(), [&](const Vector3& direction) {
      return !setup_.world->occluded(p_world_antenna, p_world_antenna + kSkyRange_m * direction);
    }));
  }

  GnssSample fix(TimeNs t, std::uint32_t index, const VehicleState& state, const Vector3& p_world_antenna,
                 int num_visible) const {
    const double dilution = std::sqrt(static_cast<double>(config_.num_satellites) / num_visible);
    const double blocked = 1.0 - static_cast<double>(num_visible) / config_.num_satellites;
    const double multipath_sigma_m = blocked * config_.multipath_sigma_m;

    GnssSample sample;
    sample.t = t;
    sample.p_world_m = p_world_antenna +
                       dilution * (white_sigma().cwiseProduct(normal3(white_, index)) + drift_.value()) +
                       altitude_.value() + multipath_sigma_m * multipath_.value();
    sample.sigma_p_m = (dilution * dilution * (white_sigma().cwiseAbs2() + drift_sigma().cwiseAbs2()) +
                        Vector3::Constant(multipath_sigma_m * multipath_sigma_m))
                           .cwiseSqrt();
    const Vector3 sigma_v(config_.sigma_velocity_xy_mps, config_.sigma_velocity_xy_mps, config_.sigma_velocity_z_mps);
    const Vector3 v_world_antenna =
        state.v_world_mps + state.q_world_body * state.omega_body_radps.cross(config_.position_m);
    sample.sigma_v_mps = dilution * sigma_v;
    sample.v_world_mps = v_world_antenna + sample.sigma_v_mps.cwiseProduct(normal3(velocity_, index));
    return sample;
  }

  GnssConfig config_;
  Schedule schedule_;
  Random white_, velocity_, drift_noise_, altitude_noise_, multipath_noise_;
  GaussMarkov drift_, altitude_, multipath_;
  RandomOutages random_outages_;
  std::vector<Vector3> satellites_;
};

}  // namespace

std::unique_ptr<Sensor> make_gnss_sensor(const ModuleConfig& config, SensorSetup setup) {
  return std::make_unique<GnssSensor>(dynamic_cast<const GnssConfig&>(config), std::move(setup));
}

}  // namespace swiftlet::sim
