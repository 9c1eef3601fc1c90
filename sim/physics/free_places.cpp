// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/physics/free_places.hpp"

#include <algorithm>

#include "sim/physics/contacts.hpp"

namespace swiftlet::sim {
namespace {

// [m] Tolerated penetration of uneven ground by the legs at a given position, which contacts resolve gently, and at a
// suggested position. Larger values accept positions from which a vehicle is pushed out faster.
constexpr double kStanding_m = 0.03;
constexpr double kFree_m = 0.001;
// [m] Vertical step of the search for a free position. Larger values step over narrow free spaces.
constexpr double kSearchStep_m = 0.05;
// [-] Largest number of steps of a search, which limits its time. In high worlds, steps are longer than kSearchStep_m.
constexpr int kMaxSteps = 4000;

}  // namespace

FreePlaces::FreePlaces(std::span<const PhysicsVehicle> vehicles, const PhysicsConfig& config, const StaticScene& world)
    : vehicles_(vehicles), world_(world), contacts_(std::make_unique<Contacts>(vehicles, config)) {}

FreePlaces::~FreePlaces() = default;

std::optional<NoRoom> FreePlaces::check(std::size_t i, const Vector3& p_world_m) {
  std::optional<NoRoom> problem = no_room_at(i, p_world_m, kStanding_m);
  if (!problem) return problem;

  // Searches upwards to the first free position, then back down to the surface.
  const double top_m = world_.bounds_m().max().z() + contacts_->reach_m(static_cast<VehicleId>(i)) + kSearchStep_m;
  const double step_m = std::max(kSearchStep_m, (top_m - p_world_m.z()) / kMaxSteps);
  const auto is_free = [&](double z) { return !no_room_at(i, {p_world_m.x(), p_world_m.y(), z}, kFree_m); };
  double free_z_m = p_world_m.z() + step_m;
  while (free_z_m < top_m && !is_free(free_z_m)) free_z_m += step_m;
  double stuck_z_m = free_z_m - step_m;
  while (free_z_m - stuck_z_m > kFree_m) {
    const double middle = 0.5 * (free_z_m + stuck_z_m);
    (is_free(middle) ? free_z_m : stuck_z_m) = middle;
  }
  problem->free_z_m = free_z_m;
  return problem;
}

std::optional<NoRoom> FreePlaces::no_room_at(std::size_t i, const Vector3& p_world_m, double tolerance_m) {
  const auto id = static_cast<VehicleId>(i);
  const double reach_m = contacts_->reach_m(id);
  if (is_below_ground(p_world_m)) return NoRoom{0.0, SurfaceClass::kGround};
  if (!world_.nearest(p_world_m, reach_m)) return std::nullopt;
  const Vector3 half = Vector3::Constant(reach_m);
  contacts_->gather_triangles(id, world_, {p_world_m - half, p_world_m + half});
  const Contacts::Overlap overlap = contacts_->overlap(id, p_world_m, vehicles_[i].start.q_world_body);
  if (overlap.depth_m <= tolerance_m) return std::nullopt;
  const auto surface = world_.nearest(overlap.p_world_m, reach_m);
  return NoRoom{overlap.depth_m, surface ? surface->surface_class : SurfaceClass::kUnlabeled};
}

/// True with ground above and no surface below.
bool FreePlaces::is_below_ground(const Vector3& p_world_m) const {
  const double down_m = p_world_m.z() - world_.bounds_m().min().z() + 1.0;
  const double up_m = world_.bounds_m().max().z() - p_world_m.z() + 1.0;
  if (up_m <= 1.0) return false;
  if (down_m > 0.0 && world_.trace(p_world_m, -Vector3::UnitZ(), down_m).range_m > 0.0F) return false;
  const RayHit above = world_.trace(p_world_m, Vector3::UnitZ(), up_m);
  return above.range_m > 0.0F && above.surface_class == SurfaceClass::kGround;
}

}  // namespace swiftlet::sim
