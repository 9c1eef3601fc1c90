// SPDX-License-Identifier: BSD-3-Clause
#include "sim/dataset/boxes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "swiftlet/core/base/elementary.hpp"

namespace swiftlet::sim {
namespace {

// [-] Rays to a vehicle along each of two axes across it. More rays measure the visible share more finely and cost
// time.
constexpr int kSilhouetteRays = 12;
// [m] Distance before its target surface at which a ray ends. At 0, rounding would let the target block the ray.
constexpr double kSkin_m = 0.01;

/// The vehicle without its rotors as a static scene in its own frame, for tracing single rays.
Scene scene_of(const VehicleShape& shape, bool with_sensors) {
  Scene scene;
  scene.materials = shape.materials;
  for (const Mesh& mesh : shape.meshes) {
    if (!with_sensors && mesh.part == VehiclePart::kSensor) continue;
    Instance instance;
    instance.mesh = static_cast<std::uint32_t>(scene.meshes.size());
    scene.instances.push_back(instance);
    scene.meshes.push_back(mesh);
    scene.meshes.back().surface_class = SurfaceClass::kVehicle;
    for (const auto& vertex : mesh.vertices_mesh_m) scene.bounds_m.extend(vertex.cast<double>());
  }
  return scene;
}

Eigen::AlignedBox3d box_of(const VehicleShape& shape) {
  Eigen::AlignedBox3d box;
  for (const Mesh& mesh : shape.meshes) {
    for (const auto& vertex : mesh.vertices_mesh_m) box.extend(vertex.cast<double>());
  }
  for (const auto& rotor : shape.rotors) {
    const Vector3 reach(rotor.radius_m, rotor.radius_m, 0.0);
    box.extend(rotor.hub_body_m.cast<double>() - reach);
    box.extend(rotor.hub_body_m.cast<double>() + reach);
  }
  return box;
}

/// Beam whose direction is nearest to the unit vector.
int nearest_beam(const BeamTable& beams, const Eigen::Vector3f& direction_lidar) {
  int nearest = 0;
  float best = -2.0F;
  for (int i = 0; i < beams.size(); ++i) {
    const float cosine = beams.directions_lidar[static_cast<std::size_t>(i)].dot(direction_lidar);
    if (cosine > best) {
      best = cosine;
      nearest = i;
    }
  }
  return nearest;
}

}  // namespace

struct BoxMaker::Body {
  Body(const VehicleShape& shape, bool with_sensors)
      : box_m(box_of(shape)), radius_m(shape.circumscribed_radius_m), scene(scene_of(shape, with_sensors)) {}

  Eigen::AlignedBox3d box_m;  ///< body frame
  double radius_m;
  StaticScene scene;
};

/// Directions covered by beams, in cells of two degrees, extended by one cell in azimuth.
struct BoxMaker::FieldOfView {
  // [-] Cells in azimuth and in elevation.
  static constexpr int kWide = 180, kHigh = 90;
  std::array<bool, static_cast<std::size_t>(kWide) * kHigh> covered{};

  explicit FieldOfView(const BeamTable& beams) {
    for (const auto& d : beams.directions_lidar) {
      const auto [x, y] = cell_of(d.cast<double>());
      for (int dx = -1; dx <= 1; ++dx) covered[static_cast<std::size_t>(y) * kWide + (x + dx + kWide) % kWide] = true;
    }
  }
  static std::pair<int, int> cell_of(const Vector3& d) {
    const double azimuth = elementary::atan2(d.y(), d.x()) / (2.0 * std::numbers::pi) + 0.5;
    const double elevation = elementary::asin(std::clamp(d.z() / d.norm(), -1.0, 1.0)) / std::numbers::pi + 0.5;
    return {std::min(static_cast<int>(azimuth * kWide), kWide - 1),
            std::min(static_cast<int>(elevation * kHigh), kHigh - 1)};
  }
  bool contains(const Vector3& direction_lidar) const {
    const auto [x, y] = cell_of(direction_lidar);
    return covered[static_cast<std::size_t>(y) * kWide + x];
  }
};

BoxMaker::BoxMaker(std::shared_ptr<const StaticScene> world,
                   const std::vector<std::shared_ptr<const VehicleShape>>& shapes, VehicleId carrier)
    : world_(std::move(world)), carrier_(carrier) {
  for (VehicleId v = 0; v < std::ssize(shapes); ++v)
    bodies_.push_back(std::make_unique<Body>(*shapes[v], v != carrier));
}

BoxMaker::~BoxMaker() = default;

std::vector<VehicleBox> BoxMaker::boxes(const LabeledScan& labeled, const StateHistory& truth) {
  const Scan& scan = labeled.scan;
  if (!view_) view_ = std::make_unique<FieldOfView>(*scan.beams);

  // Points and times of each vehicle.
  const std::size_t n = bodies_.size();
  std::vector<int> num_points(n, 0);
  std::vector<TimeNs> sum_ns(n, 0);
  const int size = scan.size();
  const std::uint16_t* const surface_class = labeled.truth.surface_class.data();
  for (int i = 0; i < size; ++i) {
    if (surface_class[i] != static_cast<std::uint16_t>(SurfaceClass::kVehicle) || !scan.hit(i)) continue;
    const int v = labeled.truth.instance[i] - 1;
    if (v < 0 || v >= static_cast<int>(n)) continue;
    ++num_points[static_cast<std::size_t>(v)];
    sum_ns[static_cast<std::size_t>(v)] += scan.time_of(i) - scan.stamp;
  }

  const auto pose_of_lidar = [&](TimeNs t) {
    const VehicleState state = truth.at(carrier_, t);
    return Pose(state.T_world_body() * labeled.truth.T_body_lidar);
  };
  const TimeNs start = scan.stamp - labeled.truth.clock_error;
  std::vector<VehicleBox> boxes;
  for (VehicleId v = 0; v < static_cast<VehicleId>(n); ++v) {
    if (v == carrier_) continue;
    const Body& body = *bodies_[static_cast<std::size_t>(v)];
    VehicleBox box;
    box.vehicle = v;
    box.num_points = num_points[static_cast<std::size_t>(v)];
    if (box.num_points > 0) {
      box.t = start + sum_ns[static_cast<std::size_t>(v)] / box.num_points;
    } else {
      const TimeNs middle = start + scan.duration / 2;
      const Vector3 p_lidar = pose_of_lidar(middle).inverse() * truth.at(v, middle).p_world_m;
      const int nearest = nearest_beam(*scan.beams, p_lidar.normalized().cast<float>());
      box.t = scan.time_of(nearest) - labeled.truth.clock_error;
    }
    const VehicleState state = truth.at(v, box.t);
    const Pose T_world_lidar = pose_of_lidar(box.t);
    box.T_world_box = state.T_world_body() * Eigen::Translation3d(body.box_m.center());
    box.T_lidar_box = T_world_lidar.inverse() * box.T_world_box;
    box.v_world_mps = state.v_world_mps;
    box.size_m = body.box_m.sizes();
    box.range_m = box.T_lidar_box.translation().norm();
    box.visible_fraction = visible_fraction(box, T_world_lidar, scan.range_max_m, truth);
    boxes.push_back(box);
  }
  return boxes;
}

double BoxMaker::visible_fraction(const VehicleBox& box, const Pose& T_world_lidar, double range_max_m,
                                  const StateHistory& truth) const {
  const Body& body = *bodies_[static_cast<std::size_t>(box.vehicle)];
  const Pose T_world_body = truth.at(box.vehicle, box.t).T_world_body();
  const Pose T_body_world = T_world_body.inverse();
  const Vector3 eye_world = T_world_lidar.translation();
  const Vector3 eye_body = T_body_world * eye_world;
  const Vector3 center = body.box_m.center();
  const Vector3 forward = (center - eye_body).normalized();
  const Vector3 right = forward.unitOrthogonal();
  const Vector3 up = forward.cross(right);
  const double reach_m = 0.5 * body.box_m.diagonal().norm();
  int met = 0, seen = 0;
  for (int i = 0; i < kSilhouetteRays; ++i) {
    for (int j = 0; j < kSilhouetteRays; ++j) {
      const double a = reach_m * ((2.0 * i + 1.0) / kSilhouetteRays - 1.0);
      const double b = reach_m * ((2.0 * j + 1.0) / kSilhouetteRays - 1.0);
      const Vector3 ray = center + a * right + b * up - eye_body;
      const Vector3 direction = ray.normalized();
      const RayHit hit = body.scene.trace(eye_body, direction, ray.norm() + 2.0 * reach_m);
      if (hit.range_m <= 0.0F) continue;
      ++met;
      const double range_m = static_cast<double>(hit.range_m);
      if (range_m > range_max_m) continue;
      const Vector3 direction_world = T_world_body.linear() * direction;
      if (!view_->contains(T_world_lidar.linear().transpose() * direction_world)) continue;
      const Vector3 surface_world = eye_world + std::max(range_m - kSkin_m, 0.0) * direction_world;
      if (!is_hidden(eye_world, surface_world, box.vehicle, box.t, truth)) ++seen;
    }
  }
  return met == 0 ? 0.0 : static_cast<double>(seen) / met;
}

bool BoxMaker::is_hidden(const Vector3& from, const Vector3& to, VehicleId target, TimeNs t,
                         const StateHistory& truth) const {
  if (world_->occluded(from, to)) return true;
  const Vector3 ray = to - from;
  const double length_m = ray.norm();
  const Vector3 direction = ray / std::max(length_m, 1e-9);
  for (VehicleId v = 0; v < std::ssize(bodies_); ++v) {
    if (v == target) continue;
    const Body& body = *bodies_[static_cast<std::size_t>(v)];
    const VehicleState state = truth.at(v, t);
    const double along_m = std::clamp((state.p_world_m - from).dot(direction), 0.0, length_m);
    if ((from + along_m * direction - state.p_world_m).norm() > body.radius_m + kSkin_m) continue;
    const Pose T_body_world = state.T_world_body().inverse();
    if (body.scene.trace(T_body_world * from, T_body_world.linear() * direction, length_m).range_m > 0.0F) return true;
  }
  return false;
}

}  // namespace swiftlet::sim
