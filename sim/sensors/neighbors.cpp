// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/sensors/neighbors.hpp"

#include <algorithm>

#include "sim/sensors/noise.hpp"
#include "swiftlet/core/base/agent.hpp"
#include "swiftlet/core/base/elementary.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

void NeighborCamera::visit(ConfigVisitor& v) {
  v.field("yaw_deg", yaw_deg, "[deg] direction of the optical axis, counter-clockwise from the body's x axis");
  v.field("pitch_deg", pitch_deg, "[deg] elevation of the optical axis above the body's x-y plane",
          Range::between(-90.0, 90.0));
  v.field("fov_deg", fov_deg, "[deg] full angle of the cone", Range{0.0, 360.0, true, false});
}

void NeighborsConfig::visit(ConfigVisitor& v) {
  v.model("model", model, "sensors", "preset: neighbors_uvdar, neighbors_ideal");
  visit_common(v);
  v.field("rate_hz", rate_hz, "[Hz] samples per second", Range::between(1e-3, 1e5));
  v.field("ideal", ideal,
          "[-] whether the sample is the truth of all other vehicles; then all following settings except the latency "
          "are ignored");
  v.field("range_max_m", range_max_m, "[m] largest range of detection", Range::positive());
  v.field("range_min_m", range_min_m, "[m] smallest range of detection", Range::non_negative());
  v.field("sigma_bearing_deg", sigma_bearing_deg, "[deg] standard deviation of the bearing by tangential axis",
          Range::non_negative());
  v.field("sigma_range_m", sigma_range_m, "[m] standard deviation of the range, constant part", Range::non_negative());
  v.field("sigma_range_relative", sigma_range_relative,
          "[-] standard deviation of the range proportional to it, added in quadrature", Range::non_negative());
  v.list("cameras", cameras, "fields of view; none: all around between the elevations");
  v.field("elevation_min_deg", elevation_min_deg, "[deg] lowest bearing in body axes when there are no cameras",
          Range::between(-90.0, 90.0));
  v.field("elevation_max_deg", elevation_max_deg, "[deg] highest bearing in body axes when there are no cameras",
          Range::between(-90.0, 90.0));
  v.field("occlusion", occlusion, "[-] whether the world and other vehicles occlude a vehicle");
  v.field("dropout_probability", dropout_probability, "[-] probability of missing a vehicle in view",
          Range::probability());
  v.field("id_swap_probability", id_swap_probability,
          "[-] probability of confusing a vehicle with another one in the same sample", Range::probability());
  v.check(elevation_max_deg >= elevation_min_deg, "elevation_max_deg", "at least elevation_min_deg");
  v.check(range_max_m > range_min_m, "range_max_m", "more than range_min_m");
}

namespace {

// [-] Radius of the sphere that occludes, relative to a vehicle's circumscribed radius. Larger values hide more
// vehicles.
constexpr double kOccluderScale = 0.5;
constexpr double kIdealVariance_m2 = 1e-6;  // positive, since filters invert the covariance

NeighborView::Cone view_cone(const NeighborCamera& camera) {
  const double yaw = camera.yaw_deg * kRadPerDeg;
  const double pitch = camera.pitch_deg * kRadPerDeg;
  return {{elementary::cos(pitch) * elementary::cos(yaw), elementary::cos(pitch) * elementary::sin(yaw),
           elementary::sin(pitch)},
          elementary::cos(0.5 * camera.fov_deg * kRadPerDeg)};
}

bool segment_meets_sphere(const Vector3& a, const Vector3& b, const Vector3& center, double radius) {
  const Vector3 ab = b - a;
  const double s = std::clamp((center - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (a + s * ab - center).squaredNorm() < radius * radius;
}

class NeighborsSensor final : public Sensor {
 public:
  NeighborsSensor(const NeighborsConfig& config, SensorSetup setup)
      : Sensor(std::move(setup)),
        config_(config),
        schedule_(config.rate_hz),
        swap_(stream("neighbors.swap")),
        view_(config.view()),
        p_world_m_(setup_.vehicle_names.size(), Vector3::Zero()) {
    // One random stream per pair, so that another vehicle does not change this pair.
    for (const std::string& other : setup_.vehicle_names) {
      noise_.emplace_back(setup_.seed, "neighbors.noise", setup_.entity + "/" + other);
      dropout_.emplace_back(setup_.seed, "neighbors.dropout", setup_.entity + "/" + other);
    }
  }

  void measure(TimeNs now, const StateHistory& truth, Observation& out) override {
    TimeNs due = 0;
    std::uint32_t index = 0;
    while (schedule_.next(now, due, index)) {
      const std::size_t first = out.neighbors.size();
      const VehicleState self = truth.at(setup_.vehicle, due);
      for (VehicleId i = 0; i < truth.num_vehicles(); ++i) p_world_m_[i] = truth.at(i, due).p_world_m;
      for (VehicleId other = 0; other < truth.num_vehicles(); ++other) {
        if (other == setup_.vehicle) continue;
        const Vector3 p_body = self.q_world_body.conjugate() * (p_world_m_[other] - self.p_world_m);
        if (config_.ideal) {
          out.neighbors.push_back({due, other, p_body, kIdealVariance_m2 * Matrix3::Identity()});
        } else if (view_.contains(p_body) && dropout_[other].uniform(index, 0) >= config_.dropout_probability &&
                   !(config_.occlusion && hidden(other))) {
          out.neighbors.push_back(seen(due, index, other, p_body));
        }
      }
      if (!config_.ideal) swap_ids(std::span(out.neighbors).subspan(first), index);
    }
  }

 private:
  bool hidden(VehicleId other) const {
    const Vector3& from = p_world_m_[setup_.vehicle];
    const Vector3& to = p_world_m_[other];
    for (VehicleId third = 0; third < static_cast<VehicleId>(p_world_m_.size()); ++third) {
      if (third == setup_.vehicle || third == other) continue;
      const double radius_m = kOccluderScale * setup_.vehicle_shapes[third]->circumscribed_radius_m;
      if (segment_meets_sphere(from, to, p_world_m_[third], radius_m)) return true;
    }
    return setup_.world && setup_.world->occluded(from, to);
  }

  /// Range noise along the bearing, bearing noise across it; the covariance is computed at the measured
  /// position, because a real sensor does not know the true one.
  NeighborSample seen(TimeNs t, std::uint32_t index, VehicleId other, const Vector3& p_body) const {
    const double sigma_bearing = config_.sigma_bearing_deg * kRadPerDeg;
    const auto sigma_range = [&](double range_m) {
      return elementary::hypot(config_.sigma_range_m, config_.sigma_range_relative * range_m);
    };
    const double true_range_m = p_body.norm();
    const Vector3 normals = normal3(noise_[other], index);
    const Vector3 bearing = p_body / true_range_m;
    const Vector3 across = bearing.unitOrthogonal();
    const Vector3 turn = sigma_bearing * (normals.x() * across + normals.y() * bearing.cross(across));
    const double range_m = std::max(0.0, true_range_m + sigma_range(true_range_m) * normals.z());
    const Vector3 measured_bearing = rotation_exp(turn) * bearing;

    const double variance_along = sigma_range(range_m) * sigma_range(range_m);
    const double variance_across = sigma_bearing * sigma_bearing * range_m * range_m;
    const Matrix3 along = measured_bearing * measured_bearing.transpose();
    return {t, other, range_m * measured_bearing,
            variance_along * along + variance_across * (Matrix3::Identity() - along)};
  }

  void swap_ids(std::span<NeighborSample> seen, std::uint32_t index) const {
    if (config_.id_swap_probability <= 0.0 || seen.size() < 2) return;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (swap_.uniform(index, static_cast<std::uint32_t>(i)) >= config_.id_swap_probability) continue;
      std::swap(seen[i].id, seen[(i + 1) % seen.size()].id);
    }
  }

  NeighborsConfig config_;
  Schedule schedule_;
  std::vector<Random> noise_, dropout_;  // indexed by VehicleId of the other vehicle
  Random swap_;
  NeighborView view_;
  std::vector<Vector3> p_world_m_;  // positions of all vehicles at the time of the sample, by VehicleId
};

}  // namespace

NeighborView NeighborsConfig::view() const {
  NeighborView view;
  if (ideal) return view;
  for (const NeighborCamera& camera : cameras) view.cones.push_back(view_cone(camera));
  view.sin_elevation_min = elementary::sin(elevation_min_deg * kRadPerDeg);
  view.sin_elevation_max = elementary::sin(elevation_max_deg * kRadPerDeg);
  view.range_min_m = range_min_m;
  view.range_max_m = range_max_m;
  return view;
}

void NeighborsConfig::describe(AgentSetup& setup) const { setup.neighbor_views.push_back(view()); }

std::unique_ptr<Sensor> make_neighbors_sensor(const ModuleConfig& config, SensorSetup setup) {
  return std::make_unique<NeighborsSensor>(dynamic_cast<const NeighborsConfig&>(config), std::move(setup));
}

}  // namespace swiftlet::sim
