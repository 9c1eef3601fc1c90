// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/lidar_faults.hpp"

#include <algorithm>
#include <limits>

#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/core/math/angles.hpp"
#include "swiftlet/sim/sensors/lidar_measurement.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {
namespace {

// [-] Entries of the table of reflectivity factors.
constexpr int kQuantiles = 4096;
/// Reflectivity of the window, of own structure close to it, and of dust on it.
constexpr float kWindowReflectivity = 0.05F;

void set_return(int beam, float range_m, float reflectivity, Scan& scan) {
  const float toward_10_m = kIntensityRange_m / range_m;
  scan.range_m[beam] = range_m;
  scan.intensity[beam] = reflectivity * toward_10_m * toward_10_m;
  scan.reflectivity[beam] = reflectivity;
}

/// Range at which a ray enters the box, by slabs; 0: not from outside.
float range_to_box_m(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, const Eigen::AlignedBox3f& box) {
  float enter = 0.0F, leave = std::numeric_limits<float>::max();
  for (int axis = 0; axis < 3; ++axis) {
    const float inverse = 1.0F / direction[axis];  // infinite for parallel rays, whose bounds are then infinite as well
    const float a = (box.min()[axis] - origin[axis]) * inverse, b = (box.max()[axis] - origin[axis]) * inverse;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : 0.0F;
}

}  // namespace

void RigPartConfig::visit(ConfigVisitor& v) {
  v.field("center_m", center_m, "[m] center of the box, body frame");
  v.field("size_m", size_m, "[m] size of the box along the body's axes", Range::positive());
  v.field("reflectivity", reflectivity, "[-] Lambertian reflectivity", Range::probability());
}

void LidarFaultsConfig::visit(ConfigVisitor& v) {
  v.field("dropout_probability", dropout_probability, "[-] share of shots without return, regardless of the surface",
          Range::probability());
  v.field("tail_probability", tail_probability, "[-] share of returns with tail_factor times the noise",
          Range::probability());
  v.field("tail_factor", tail_factor, "[-] factor of the noise of outliers", Range::between(1.0, 1e3));
  v.field("range_step_m", range_step_m, "[m] resolution of the reported range; 0: continuous", Range::non_negative());
  v.field("reflectivity_spread", reflectivity_spread,
          "[-] scale of a log-logistic factor of the reflectivity from shot to shot; 0: uniform surfaces",
          Range::between(0.0, 0.9));
  v.field("near_per_sweep", near_per_sweep, "[-] mean number of returns of the sensor's window in a sweep",
          Range::non_negative());
  v.field("near_range_m", near_range_m, "[m] smallest and largest range of returns of the window", Range::positive());
  v.list("rig", rig, "parts of the vehicle's structure that the self-mask does not remove");
  v.check(dropout_probability + tail_probability <= 1.0, "tail_probability", "at most 1 with dropout_probability");
  v.check(near_range_m.y() >= near_range_m.x(), "near_range_m", "the least range first");
}

LidarFaults::LidarFaults(const LidarFaultsConfig& config, bool ideal, std::uint64_t seed, const std::string& entity,
                         int num_beams)
    : config_(ideal ? LidarFaultsConfig{} : config),
      share_random_(seed, "lidar.faults", entity),
      reflectivity_random_(seed, "lidar.reflectivity", entity),
      window_random_(seed, "lidar.window", entity) {
  const double s = config_.reflectivity_spread;
  if (config_.dropout_probability + config_.tail_probability > 0.0 || s > 0.0) uniforms_.resize(num_beams);
  if (s <= 0.0) return;
  reflectivity_factors_.resize(num_beams);
  const double median = elementary::sin(kPi * s) / (kPi * s);
  for (int k = 0; k < kQuantiles; ++k) {
    const double u = (k + 0.5) / kQuantiles;
    reflectivity_quantiles_.push_back(static_cast<float>(median * elementary::pow(u / (1.0 - u), s)));
  }
}

void LidarFaults::draw(std::uint32_t sweep, int first, std::span<float> range_normals) {
  if (uniforms_.empty()) return;
  const std::span uniforms = std::span(uniforms_).subspan(first, range_normals.size());
  const auto lost = static_cast<float>(config_.dropout_probability);
  const auto lost_or_tail = static_cast<float>(config_.dropout_probability + config_.tail_probability);
  const auto tail = static_cast<float>(config_.tail_factor);
  if (lost_or_tail > 0.0F) {
    share_random_.fill_uniform(sweep, first, uniforms);
    for (std::size_t i = 0; i < uniforms.size(); ++i) {
      if (uniforms[i] >= lost_or_tail) continue;
      range_normals[i] = uniforms[i] < lost ? -std::numeric_limits<float>::infinity() : tail * range_normals[i];
    }
  }
  if (reflectivity_factors_.empty()) return;
  reflectivity_random_.fill_uniform(sweep, first, uniforms);
  for (std::size_t i = 0; i < uniforms.size(); ++i) {
    reflectivity_factors_[first + i] =
        reflectivity_quantiles_[std::min(static_cast<int>(uniforms[i] * kQuantiles), kQuantiles - 1)];
  }
}

void LidarFaults::add_near_returns(std::uint32_t sweep, VehicleId self, float range_min_m, LabeledScan& out) const {
  if (!config_.rig.empty()) add_rig(self, range_min_m, out);
  if (config_.near_per_sweep > 0.0) add_window(sweep, out);
}

void LidarFaults::add_window(std::uint32_t sweep, LabeledScan& out) const {
  const int count = static_cast<int>(config_.near_per_sweep + window_random_.uniform(sweep, 0));
  for (int k = 1; k <= count; ++k) {
    const int beam = static_cast<int>(window_random_.uniform(sweep, 2 * k) * out.scan.size());
    const double range_m = window_random_.uniform(config_.near_range_m.x(), config_.near_range_m.y(), sweep, 2 * k + 1);
    const auto returned_m = static_cast<float>(range_m);
    set_return(beam, has_range_step() ? rounded_m(returned_m) : returned_m, kWindowReflectivity, out.scan);
    out.truth.range_m[beam] = out.truth.incidence_rad[beam] = 0.0F;
    out.truth.surface_class[beam] = out.truth.instance[beam] = 0;
    out.truth.part[beam] = 0;
  }
}

void LidarFaults::add_rig(VehicleId self, float range_min_m, LabeledScan& out) const {
  const Eigen::Isometry3f T_body_lidar = out.truth.T_body_lidar.cast<float>();
  const BeamTable& beams = *out.scan.beams;
  for (const RigPartConfig& part : config_.rig) {
    const Eigen::Vector3f center = part.center_m.cast<float>(), half = 0.5F * part.size_m.cast<float>();
    const Eigen::AlignedBox3f box(Eigen::Vector3f(center - half), Eigen::Vector3f(center + half));
    for (int i = 0; i < beams.size(); ++i) {
      const float range_m =
          range_to_box_m(T_body_lidar * beams.origins_lidar[i], T_body_lidar.linear() * beams.directions_lidar[i], box);
      if (range_m < range_min_m || range_m <= 0.0F) continue;
      if (out.truth.range_m[i] > 0.0F && out.truth.range_m[i] <= range_m) continue;
      set_return(i, has_range_step() ? rounded_m(range_m) : range_m, static_cast<float>(part.reflectivity), out.scan);
      out.truth.range_m[i] = range_m;
      out.truth.incidence_rad[i] = 0.0F;
      out.truth.surface_class[i] = static_cast<std::uint16_t>(SurfaceClass::kVehicle);
      out.truth.instance[i] = static_cast<std::uint16_t>(self + 1);
      out.truth.part[i] = static_cast<std::uint8_t>(VehiclePart::kBody);
    }
  }
}

}  // namespace swiftlet::sim
