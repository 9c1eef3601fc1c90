// SPDX-License-Identifier: BSD-3-Clause
#include "core/mappers/vehicles_around.hpp"

#include <algorithm>
#include <cmath>

namespace swiftlet {
namespace {

/// [m] Edge of a cell of the periodic grid. Larger cells test more points exactly; smaller ones mark more cells.
constexpr double kCell_m = 4.0;
constexpr double kMemory_s = 0.5;   // longest age of a position sample of a neighbor
constexpr double kFlies_mps = 2.0;  // assumed speed of a neighbor since its sample, in any direction
/// [-] Standard deviations of a position by which its volume grows. Larger values leave fewer returns of vehicles in
/// the map, and omit more obstacles beside them.
constexpr double kSigmas = 2.0;
constexpr double kScan_s = 0.3;  // duration of a scan, during which a tracked vehicle moves on

}  // namespace

std::size_t VehiclesAround::cell_of(double x_m, double y_m) {
  const auto along = [](double m) {
    return static_cast<std::size_t>(static_cast<long>(std::floor(m / kCell_m))) % kSide;
  };
  return along(y_m) * kSide + along(x_m);
}

void VehiclesAround::update(const MapperInput& input) {
  if (radius_m_ <= 0.0) return;
  receive(input);
  if (input.clouds.empty()) return;
  vehicles_.clear();
  marked_.reset();
  const Matrix3 around_m2 = radius_m_ * radius_m_ * Matrix3::Identity();
  const TimeNs now = input.observation.t;
  const auto add_known = [&](const auto& vehicle) {
    add({vehicle.t, vehicle.position_m, vehicle.velocity_mps, around_m2.inverse()}, now,
        radius_m_ + kScan_s * vehicle.velocity_mps.norm());
  };
  for (const Track& track : input.tracks) add_known(track);
  for (const RelativeEstimate& member : input.relatives) add_known(member);
  std::erase_if(samples_, [&](const Sample& sample) { return now - sample.t > from_seconds(kMemory_s); });
  for (const Sample& sample : samples_) {
    const double around_m = radius_m_ + kFlies_mps * to_seconds(now - sample.t);
    const Matrix3 spread_m2 =
        kSigmas * kSigmas * sample.covariance_local_m2 + around_m * around_m * Matrix3::Identity();
    add({sample.t, sample.p_local_m, Vector3::Zero(), spread_m2.inverse()}, now, std::sqrt(spread_m2.trace()));
  }
}

void VehiclesAround::receive(const MapperInput& input) {
  for (const NeighborSample& neighbor : input.neighbors) {
    const Pose T_local_body = input.poses != nullptr ? input.poses->at(neighbor.t) : input.estimate.T_local_body;
    const Matrix3& R = T_local_body.linear();
    const Sample sample{neighbor.id, neighbor.t, T_local_body * neighbor.p_body_m,
                        R * neighbor.covariance_body * R.transpose()};
    const auto at = std::lower_bound(samples_.begin(), samples_.end(), neighbor.id,
                                     [](const Sample& s, VehicleId id) { return s.id < id; });
    if (at == samples_.end() || at->id != neighbor.id || neighbor.id == kNoVehicle) {
      samples_.insert(at, sample);
    } else if (at->t <= neighbor.t) {
      *at = sample;
    }
  }
}

/// @param reach_m  largest distance of the vehicle's points from its present position
void VehiclesAround::add(const Vehicle& vehicle, TimeNs now, double reach_m) {
  vehicles_.push_back(vehicle);
  const Vector3 now_m = vehicle.p_local_m + to_seconds(now - vehicle.t) * vehicle.v_local_mps;
  const int steps = static_cast<int>(std::ceil(2.0 * reach_m / kCell_m));
  for (int x = 0; x <= steps; ++x) {
    for (int y = 0; y <= steps; ++y) {
      marked_[cell_of(now_m.x() - reach_m + std::min(x * kCell_m, 2.0 * reach_m),
                      now_m.y() - reach_m + std::min(y * kCell_m, 2.0 * reach_m))] = true;
    }
  }
}

bool VehiclesAround::is_one(const Vector3& p_local_m, TimeNs t) const {
  return std::any_of(vehicles_.begin(), vehicles_.end(), [&](const Vehicle& vehicle) {
    const Vector3 from_m = p_local_m - vehicle.p_local_m - to_seconds(t - vehicle.t) * vehicle.v_local_mps;
    return from_m.dot(vehicle.inverse_m2 * from_m) < 1.0;
  });
}

}  // namespace swiftlet
