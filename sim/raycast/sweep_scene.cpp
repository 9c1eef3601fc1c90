// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/raycast/sweep_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/raycast/embree_scene.hpp"
#include "sim/raycast/exact_hits_internal.hpp"
#include "sim/raycast/waving_foliage.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {
namespace {

constexpr TimeNs kKnotSpacing = 2'000'000;  // 2 ms
// Upper bound of any vehicle's speed, to find vehicles that may come into range
constexpr double kFastest_mps = 60.0;
constexpr float kCullingSlack_m = 0.02F;  // single precision at some 100 m
constexpr double kTwoPi = 6.283185307179586;

/// State of a vehicle at one instant of the sweep.
struct Knot {
  Eigen::Vector3d p_world;
  Eigen::Quaterniond q_world_body;
  std::array<double, kMaxRotors> rotor_angle_rad;
  std::array<double, kMaxRotors> rotor_rate_radps;  // signed
};

/// Position of an instant between the knots.
struct KnotPlace {
  int before = 0;
  float fraction = 0.0F;  // interpolation weight of the next knot
};

struct Vehicle {
  std::shared_ptr<const VehicleShape> shape;
  std::shared_ptr<const VehicleBody> body;
  std::uint32_t first_surface = 0;  // first surface index of its body
  std::uint32_t rotor_surface = 0;
  float radius_m = 0.0F;  // radius of the sphere about its origin that contains the vehicle
  std::vector<Knot> knots;
  // Sphere that contains the vehicle during the whole sweep, world frame.
  Eigen::Vector3f sweep_center_m = Eigen::Vector3f::Zero();
  float sweep_radius_m = 0.0F;
};

/// Sensor-to-world transform of one firing, with the origin of its beams.
struct FiringTransform {
  float r[9];  // rows of R_world_lidar
  float t[3];
};

double bounding_radius_m(const VehicleShape& shape) {
  double radius = 0.0;
  for (const Mesh& mesh : shape.meshes) {
    for (const Eigen::Vector3f& v : mesh.vertices_mesh_m) radius = std::max(radius, static_cast<double>(v.norm()));
  }
  for (const auto& rotor : shape.rotors) {
    radius = std::max(radius, static_cast<double>(rotor.hub_body_m.norm() + rotor.radius_m));
  }
  return radius + 1e-3;
}

// Normalized linear interpolation along the shorter arc: between knots 2 ms apart indistinguishable from slerp.
Eigen::Quaterniond nlerp(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double s) {
  const double sign = a.dot(b) < 0.0 ? -1.0 : 1.0;
  return Eigen::Quaterniond((1.0 - s) * a.coeffs() + sign * s * b.coeffs()).normalized();
}

// Angle of a rotor between two knots: cubic Hermite from angles and rates.
double rotor_angle(const Knot& a, const Knot& b, int rotor, double s, double h) {
  const double s2 = s * s, s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * a.rotor_angle_rad[rotor] + (s3 - 2 * s2 + s) * h * a.rotor_rate_radps[rotor] +
         (3 * s2 - 2 * s3) * b.rotor_angle_rad[rotor] + (s3 - s2) * h * b.rotor_rate_radps[rotor];
}

}  // namespace

struct SweepScene::Impl {
  std::shared_ptr<const StaticScene> world;
  std::unique_ptr<WavingFoliage> foliage;  // null: nothing moves
  std::vector<Vehicle> vehicles;           // indexed by VehicleId
  std::vector<int> in_reach;               // other vehicles, ascending
  std::vector<SweepSurface> surfaces;
  VehicleId self = 0;
  Pose T_body_lidar = Pose::Identity();
  Eigen::Matrix3f R_body_lidar = Eigen::Matrix3f::Identity();
  Eigen::Vector3f p_body_lidar = Eigen::Vector3f::Zero();
  float range_max_m = 0.0F;
  bool coherent = true;

  std::vector<Firing> firings;
  std::vector<KnotPlace> places;              // (firings)
  std::vector<FiringTransform> transforms;    // (firings)
  std::vector<Pose> poses;                    // (firings), T_world_lidar
  std::vector<Eigen::Vector3f> origins_body;  // (firings)
  int num_knots = 1;
  double knot_spacing_s = 0.0;
  TimeNs duration = -1;  // duration of the sweep for which `places` were computed

  void place_firings();
  void look_up(const StateHistory& truth, VehicleId id, TimeNs start, Vehicle& vehicle) const;
  bool may_come_into_reach(const StateHistory& truth, VehicleId id, TimeNs start) const;
  void transform_firings();

  Rays rays_world(const BeamPacket& beams) const;
  Rays rays_body(const BeamPacket& beams) const;
  Rays rays_of(const Vehicle& vehicle, const BeamPacket& beams, const Rays& world_rays) const;
  bool near(const Vehicle& vehicle, const Rays& world_rays, const std::array<float, kPacketSize>& tfar) const;
  void meet_leaves(const Rays& world_rays, std::array<float, kPacketSize>& tfar, PacketHits& hits) const;
  void meet(const Vehicle& vehicle, const BeamPacket& beams, const Rays& rays, std::array<float, kPacketSize>& tfar,
            PacketHits& hits) const;
  void meet_rotors(const Vehicle& vehicle, const BeamPacket& beams, const Rays& rays,
                   std::array<float, kPacketSize>& tfar, PacketHits& hits) const;
};

// ---- preparation of a sweep ----

void SweepScene::Impl::place_firings() {
  const double duration_s = to_seconds(duration);
  num_knots = duration == 0 ? 1 : static_cast<int>((duration + kKnotSpacing - 1) / kKnotSpacing) + 1;
  knot_spacing_s = num_knots == 1 ? 0.0 : duration_s / (num_knots - 1);
  for (std::size_t i = 0; i < firings.size(); ++i) {
    if (num_knots == 1) {
      places[i] = {0, 0.0F};
      continue;
    }
    const double place = std::clamp(static_cast<double>(firings[i].offset_s), 0.0, duration_s) / knot_spacing_s;
    const int before = std::min(static_cast<int>(place), num_knots - 2);
    places[i] = {before, static_cast<float>(place - before)};
  }
  for (Vehicle& vehicle : vehicles) vehicle.knots.resize(num_knots);
}

void SweepScene::Impl::look_up(const StateHistory& truth, VehicleId id, TimeNs start, Vehicle& vehicle) const {
  for (int k = 0; k < num_knots; ++k) {
    const TimeNs t = num_knots == 1 ? start : start + duration * k / (num_knots - 1);
    const VehicleState state = truth.at(id, t);
    Knot& knot = vehicle.knots[k];
    knot.p_world = state.p_world_m;
    knot.q_world_body = state.q_world_body;
    knot.rotor_angle_rad = state.rotor_angle_rad;
    for (std::size_t r = 0; r < vehicle.shape->rotors.size(); ++r) {
      knot.rotor_rate_radps[r] = vehicle.shape->rotors[r].direction * state.rotor_speed_radps[r];
    }
  }
  Eigen::AlignedBox3d box;
  for (const Knot& knot : vehicle.knots) box.extend(knot.p_world);
  vehicle.sweep_center_m = box.center().cast<float>();
  vehicle.sweep_radius_m = static_cast<float>(0.5 * box.diagonal().norm() + vehicle.radius_m) + kCullingSlack_m;
}

bool SweepScene::Impl::may_come_into_reach(const StateHistory& truth, VehicleId id, TimeNs start) const {
  const Vector3 between = truth.at(id, start).p_world_m - vehicles[self].knots[0].p_world;
  return between.norm() < range_max_m + vehicles[id].radius_m + vehicles[self].radius_m +
                              T_body_lidar.translation().norm() + 2.0 * kFastest_mps * to_seconds(duration);
}

void SweepScene::Impl::transform_firings() {
  for (std::size_t i = 0; i < firings.size(); ++i) {
    const KnotPlace& place = places[i];
    const Knot& a = vehicles[self].knots[place.before];
    const Knot& b = vehicles[self].knots[std::min(place.before + 1, num_knots - 1)];
    const Eigen::Matrix3d R_world_body = nlerp(a.q_world_body, b.q_world_body, place.fraction).toRotationMatrix();
    const Vector3 p_world = a.p_world + place.fraction * (b.p_world - a.p_world);
    poses[i].linear() = R_world_body * T_body_lidar.linear();
    poses[i].translation() = p_world + R_world_body * T_body_lidar.translation();
    const Eigen::Matrix3f R = poses[i].linear().cast<float>();
    const Eigen::Vector3f t = (p_world + R_world_body * origins_body[i].cast<double>()).cast<float>();
    FiringTransform& out = transforms[i];
    Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(out.r) = R;
    Eigen::Map<Eigen::Vector3f>(out.t) = t;
  }
}

// ---- rays of a packet in the frames ----

Rays SweepScene::Impl::rays_world(const BeamPacket& beams) const {
  Rays rays;
  for (int i = 0; i < kPacketSize; ++i) {
    const FiringTransform& T = transforms[beams.firing[i]];
    const float x = beams.direction_x[i], y = beams.direction_y[i], z = beams.direction_z[i];
    rays.direction_x[i] = T.r[0] * x + T.r[1] * y + T.r[2] * z;
    rays.direction_y[i] = T.r[3] * x + T.r[4] * y + T.r[5] * z;
    rays.direction_z[i] = T.r[6] * x + T.r[7] * y + T.r[8] * z;
    rays.origin_x[i] = T.t[0];
    rays.origin_y[i] = T.t[1];
    rays.origin_z[i] = T.t[2];
  }
  return rays;
}

Rays SweepScene::Impl::rays_body(const BeamPacket& beams) const {
  Rays rays;
  for (int i = 0; i < kPacketSize; ++i) {
    const Eigen::Vector3f direction =
        R_body_lidar * Eigen::Vector3f(beams.direction_x[i], beams.direction_y[i], beams.direction_z[i]);
    const Eigen::Vector3f& origin = origins_body[beams.firing[i]];
    rays.set(i, origin, direction);
  }
  return rays;
}

Rays SweepScene::Impl::rays_of(const Vehicle& vehicle, const BeamPacket& beams, const Rays& world_rays) const {
  Rays rays;
  for (int i = 0; i < kPacketSize; ++i) {
    const KnotPlace& place = places[beams.firing[i]];
    const Knot& a = vehicle.knots[place.before];
    const Knot& b = vehicle.knots[std::min(place.before + 1, num_knots - 1)];
    const Eigen::Matrix3d R_body_world =
        nlerp(a.q_world_body, b.q_world_body, place.fraction).toRotationMatrix().transpose();
    const Eigen::Vector3d p = a.p_world + place.fraction * (b.p_world - a.p_world);
    const Eigen::Vector3d origin_world(world_rays.origin_x[i], world_rays.origin_y[i], world_rays.origin_z[i]);
    const Eigen::Vector3f origin = (R_body_world * (origin_world - p)).cast<float>();
    const Eigen::Vector3f direction =
        R_body_world.cast<float>() *
        Eigen::Vector3f(world_rays.direction_x[i], world_rays.direction_y[i], world_rays.direction_z[i]);
    rays.set(i, origin, direction);
  }
  return rays;
}

// ---- intersection with vehicles ----

// True if any ray meets the vehicle's sweep sphere before its current intersection.
bool SweepScene::Impl::near(const Vehicle& vehicle, const Rays& rays,
                            const std::array<float, kPacketSize>& tfar) const {
  const float cx = vehicle.sweep_center_m.x(), cy = vehicle.sweep_center_m.y(), cz = vehicle.sweep_center_m.z();
  const float radius = vehicle.sweep_radius_m;
  int any = 0;
  for (int i = 0; i < kPacketSize; ++i) {
    const float x = cx - rays.origin_x[i], y = cy - rays.origin_y[i], z = cz - rays.origin_z[i];
    const float along = x * rays.direction_x[i] + y * rays.direction_y[i] + z * rays.direction_z[i];
    const float across_sq = x * x + y * y + z * z - along * along;
    any |= (across_sq < radius * radius) & (along > -radius) & (along < tfar[i] + radius);
  }
  return any != 0;
}

void SweepScene::Impl::meet_leaves(const Rays& rays, std::array<float, kPacketSize>& tfar, PacketHits& hits) const {
  ExactQuery query(foliage->leaves());
  query.set_rays(rays, tfar);
  coherent ? query.trace_together() : query.trace_scattered();
  for (int i = 0; i < kPacketSize; ++i) {
    if (!query.met(i)) continue;
    tfar[i] = hits.range_m[i] = query.range_m(i);
    hits.cos_incidence[i] = query.cos_incidence(i);
    hits.surface[i] = query.surface(i);
  }
}

void SweepScene::Impl::meet(const Vehicle& vehicle, const BeamPacket& beams, const Rays& rays,
                            std::array<float, kPacketSize>& tfar, PacketHits& hits) const {
  const TriangleScene& body = vehicle.body->triangles;
  ExactQuery query(body);
  query.set_rays(rays, tfar);
  query.trace_together();
  for (int i = 0; i < kPacketSize; ++i) {
    if (!query.met(i)) continue;
    tfar[i] = hits.range_m[i] = query.range_m(i);
    hits.cos_incidence[i] = query.cos_incidence(i);
    hits.surface[i] = vehicle.first_surface + query.surface(i);
  }
  meet_rotors(vehicle, beams, rays, tfar, hits);
}

// A blade is placed at the instant of each beam: flat, in the plane of its disc.
void SweepScene::Impl::meet_rotors(const Vehicle& vehicle, const BeamPacket& beams, const Rays& rays,
                                   std::array<float, kPacketSize>& tfar, PacketHits& hits) const {
  const auto& rotors = vehicle.shape->rotors;
  for (std::size_t r = 0; r < rotors.size(); ++r) {
    const auto& rotor = rotors[r];
    for (int i = 0; i < kPacketSize; ++i) {
      const float t = (rotor.hub_body_m.z() - rays.origin_z[i]) / rays.direction_z[i];
      if (!(t > 0.0F && t < tfar[i])) continue;
      const float x = rays.origin_x[i] + t * rays.direction_x[i] - rotor.hub_body_m.x();
      const float y = rays.origin_y[i] + t * rays.direction_y[i] - rotor.hub_body_m.y();
      if (x * x + y * y > rotor.radius_m * rotor.radius_m) continue;
      const KnotPlace& place = places[beams.firing[i]];
      const Knot& a = vehicle.knots[place.before];
      const Knot& b = vehicle.knots[std::min(place.before + 1, num_knots - 1)];
      const double angle = rotor_angle(a, b, static_cast<int>(r), place.fraction, knot_spacing_s);
      if (!VehicleShape::blade_covers(rotor, x, y, std::remainder(angle, kTwoPi))) continue;
      tfar[i] = hits.range_m[i] = t;
      hits.cos_incidence[i] = std::min(std::abs(rays.direction_z[i]), 1.0F);
      hits.surface[i] = vehicle.rotor_surface;
    }
  }
}

// ---- interface ----

SweepScene::SweepScene(std::shared_ptr<const StaticScene> world,
                       std::vector<std::shared_ptr<const VehicleShape>> shapes, VehicleId self,
                       const Pose& T_body_lidar, double range_max_m)
    : impl_(std::make_unique<Impl>()) {
  impl_->world = std::move(world);
  impl_->self = self;
  impl_->T_body_lidar = T_body_lidar;
  impl_->R_body_lidar = T_body_lidar.linear().cast<float>();
  impl_->p_body_lidar = T_body_lidar.translation().cast<float>();
  impl_->range_max_m = static_cast<float>(range_max_m);
  for (const Surface& s : impl_->world->impl().world.surfaces) {
    impl_->surfaces.push_back({s.material, s.surface_class, s.instance, VehiclePart::kNone, kNoVehicle});
  }
  for (std::size_t id = 0; id < shapes.size(); ++id) {
    Vehicle vehicle;
    vehicle.shape = shapes[id];
    vehicle.body = impl_->world->impl().body_of(shapes[id], static_cast<VehicleId>(id) != self);
    vehicle.radius_m = static_cast<float>(bounding_radius_m(*shapes[id]));
    vehicle.first_surface = static_cast<std::uint32_t>(impl_->surfaces.size());
    const auto instance = static_cast<std::uint16_t>(id + 1);
    const auto vehicle_id = static_cast<VehicleId>(id);
    for (const Surface& s : vehicle.body->triangles.surfaces) {
      impl_->surfaces.push_back({s.material, SurfaceClass::kVehicle, instance, s.part, vehicle_id});
    }
    vehicle.rotor_surface = static_cast<std::uint32_t>(impl_->surfaces.size());
    impl_->surfaces.push_back(
        {shapes[id]->rotor_material, SurfaceClass::kVehicle, instance, VehiclePart::kRotor, vehicle_id});
    impl_->vehicles.push_back(std::move(vehicle));
  }
  if (impl_->world->impl().foliage) impl_->foliage = std::make_unique<WavingFoliage>(impl_->world);
  impl_->in_reach.reserve(shapes.size());
  set_firings({});
}

SweepScene::~SweepScene() = default;

void SweepScene::set_firings(std::span<const Firing> firings, bool coherent) {
  impl_->coherent = coherent;
  if (!coherent) impl_->world->impl().expect_scattered_rays();
  impl_->poses.resize(firings.size(), Pose::Identity());
  impl_->firings.assign(firings.begin(), firings.end());
  impl_->places.resize(firings.size());
  impl_->transforms.resize(firings.size());
  impl_->origins_body.resize(firings.size());
  for (std::size_t i = 0; i < firings.size(); ++i) {
    impl_->origins_body[i] = impl_->R_body_lidar * firings[i].origin_lidar_m + impl_->p_body_lidar;
  }
  impl_->duration = -1;
}

void SweepScene::begin(const StateHistory& truth, TimeNs start, TimeNs duration) {
  Impl& s = *impl_;
  if (s.duration != duration) {
    s.duration = duration;
    s.place_firings();
  }
  s.look_up(truth, s.self, start, s.vehicles[s.self]);
  s.transform_firings();
  s.in_reach.clear();
  for (VehicleId id = 0; id < static_cast<VehicleId>(s.vehicles.size()); ++id) {
    if (id == s.self || !s.may_come_into_reach(truth, id, start)) continue;
    s.look_up(truth, id, start, s.vehicles[id]);
    s.in_reach.push_back(id);
  }
  if (s.foliage) s.foliage->move_to(start + duration / 2);
}

void SweepScene::trace(const BeamPacket& beams, bool meets_self, PacketHits& hits) const {
  const Impl& s = *impl_;
  const Rays rays = s.rays_world(beams);
  std::array<float, kPacketSize> tfar;
  tfar.fill(s.range_max_m);

  const StaticScene::Impl& world = s.world->impl();
  ExactQuery query(s.foliage ? world.foliage->firm : world.world);
  query.set_rays(rays, tfar);
  s.coherent ? query.trace_together() : query.trace_scattered();
  for (int i = 0; i < kPacketSize; ++i) {
    const bool met = query.met(i);
    hits.range_m[i] = met ? query.range_m(i) : 0.0F;
    hits.cos_incidence[i] = met ? query.cos_incidence(i) : 0.0F;
    hits.surface[i] = met ? query.surface(i) : 0;
    if (met) tfar[i] = hits.range_m[i];
  }

  if (s.foliage) s.meet_leaves(rays, tfar, hits);
  if (meets_self) s.meet(s.vehicles[s.self], beams, s.rays_body(beams), tfar, hits);
  for (const int id : s.in_reach) {
    const Vehicle& vehicle = s.vehicles[id];
    if (s.near(vehicle, rays, tfar)) s.meet(vehicle, beams, s.rays_of(vehicle, beams, rays), tfar, hits);
  }
}

std::uint32_t SweepScene::reaches_self(const BeamPacket& beams) const {
  const Impl& s = *impl_;
  const Vehicle& self = s.vehicles[s.self];
  const Rays rays = s.rays_body(beams);
  std::array<float, kPacketSize> tfar;
  tfar.fill(s.range_max_m);
  ExactQuery query(self.body->triangles);
  query.set_rays(rays, tfar);
  query.trace_together();
  std::uint32_t met = 0;
  for (int i = 0; i < kPacketSize; ++i) {
    bool meets = query.met(i);
    for (const auto& rotor : self.shape->rotors) {
      const float t = (rotor.hub_body_m.z() - rays.origin_z[i]) / rays.direction_z[i];
      const float x = rays.origin_x[i] + t * rays.direction_x[i] - rotor.hub_body_m.x();
      const float y = rays.origin_y[i] + t * rays.direction_y[i] - rotor.hub_body_m.y();
      meets |= t > 0.0F && t < s.range_max_m && x * x + y * y <= rotor.radius_m * rotor.radius_m;
    }
    met |= static_cast<std::uint32_t>(meets) << i;
  }
  return met;
}

std::span<const SweepSurface> SweepScene::surfaces() const { return impl_->surfaces; }

const Pose& SweepScene::T_world_lidar(int firing) const { return impl_->poses[firing]; }

}  // namespace swiftlet::sim
