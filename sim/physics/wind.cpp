// SPDX-License-Identifier: BSD-3-Clause
#include "sim/physics/wind.hpp"

#include <algorithm>
#include <cmath>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {
namespace {

constexpr double kMetersPerFoot = 0.3048;
// [m/s] Least speed at which a vehicle crosses the frozen turbulence. At 0, gusts on a hovering vehicle would never
// change.
constexpr double kMinCrossingSpeed_mps = 1.0;

}  // namespace

void WindConfig::visit(ConfigVisitor& v) {
  v.field("mean_mps", mean_mps, "[m/s] velocity of the mean wind in the world frame", Range::between(-100.0, 100.0));
  v.field("gusts", gusts, "[-] whether Dryden turbulence is added to the mean wind");
  v.field("wind_at_6m_mps", wind_at_6m_mps,
          "[m/s] W20 of MIL-F-8785C, the strength of the turbulence: 7.7 light, 15.4 moderate, 23.2 severe",
          Range::between(0.0, 100.0));
}

DrydenScales dryden_scales(double height_m, double wind_at_6m_mps) {
  const double height_ft = std::clamp(height_m / kMetersPerFoot, 10.0, 1000.0);
  const double shape = 0.177 + 0.000823 * height_ft;
  const double length_u_m = height_ft / elementary::pow(shape, 1.2) * kMetersPerFoot;
  const double sigma_w_mps = 0.1 * wind_at_6m_mps;
  const double sigma_u_mps = sigma_w_mps / elementary::pow(shape, 0.4);
  return {{length_u_m, length_u_m, height_ft * kMetersPerFoot}, {sigma_u_mps, sigma_u_mps, sigma_w_mps}};
}

Gusts::Gusts(const WindConfig& config, std::uint64_t seed, std::string_view vehicle)
    : config_(config), random_(seed, "wind.gust", vehicle), mean_speed_mps_(config.mean_mps.norm()) {
  const double horizontal_mps = config.mean_mps.head<2>().norm();
  if (horizontal_mps > 0.0) along_ = Vector3(config.mean_mps.x(), config.mean_mps.y(), 0.0) / horizontal_mps;
  left_ = Vector3::UnitZ().cross(along_);
  const auto start = random_.normal3(0, 0);
  unit_gust_ = {start[0], start[1], start[2]};
}

const Vector3& Gusts::advance(std::uint32_t step, double dt_s, double height_m, double airspeed_mps) {
  const DrydenScales scales = dryden_scales(height_m, config_.wind_at_6m_mps);
  const double crossed_m = std::max({airspeed_mps, mean_speed_mps_, kMinCrossingSpeed_mps}) * dt_s;
  if (step > 0) {
    const Vector3 memory = {elementary::exp(-crossed_m / scales.scale_length_m.x()),
                            elementary::exp(-2.0 * crossed_m / scales.scale_length_m.y()),
                            elementary::exp(-2.0 * crossed_m / scales.scale_length_m.z())};
    const auto noise = random_.normal3(step, 0);
    for (int i = 0; i < 3; ++i) {
      unit_gust_[i] = memory[i] * unit_gust_[i] + std::sqrt(1.0 - memory[i] * memory[i]) * noise[i];
    }
  }
  const Vector3 gust = scales.sigma_mps.cwiseProduct(unit_gust_);
  gust_world_mps_ = gust.x() * along_ + gust.y() * left_ + gust.z() * Vector3::UnitZ();
  return gust_world_mps_;
}

}  // namespace swiftlet::sim
