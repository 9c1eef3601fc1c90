// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "swiftlet/sim/raycast/ray_scene.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

/// Where another vehicle was when the beams of one sweep passed it.
struct VehicleBox {
  VehicleId vehicle = kNoVehicle;
  TimeNs t = 0;                         ///< mean time of its points; without points: when beams passed its place
  Pose T_lidar_box = Pose::Identity();  ///< center of the box, axes of the vehicle's body; lidar frame at t
  Pose T_world_box = Pose::Identity();
  Vector3 v_world_mps = Vector3::Zero();
  Vector3 size_m = Vector3::Zero();  ///< along the body's axes, propeller discs included
  double range_m = 0.0;              ///< from the sensor to the center
  int num_points = 0;                ///< returns from it
  /// Share of the vehicle's silhouette (without its propellers) that the sensor has in its field of view and in reach.
  /// Nothing is in front of that share: neither the world nor a vehicle, be it the sensor's own.
  double visible_fraction = 0.0;
};

/// Makes the boxes of all vehicles but the one that carries the sensor. One per sensor.
class BoxMaker {
 public:
  BoxMaker(std::shared_ptr<const StaticScene> world, const std::vector<std::shared_ptr<const VehicleShape>>& shapes,
           VehicleId carrier);
  ~BoxMaker();

  /// @param truth  reaches back to the start of the sweep
  std::vector<VehicleBox> boxes(const LabeledScan& scan, const StateHistory& truth);

 private:
  struct Body;
  struct FieldOfView;
  double visible_fraction(const VehicleBox& box, const Pose& T_world_lidar, double range_max_m,
                          const StateHistory& truth) const;
  bool is_hidden(const Vector3& from_world_m, const Vector3& to_world_m, VehicleId target, TimeNs t,
                 const StateHistory& truth) const;

  std::shared_ptr<const StaticScene> world_;
  std::vector<std::unique_ptr<Body>> bodies_;  // by VehicleId; that of the carrier as seen from aboard
  VehicleId carrier_;
  std::unique_ptr<FieldOfView> view_;  // from the first scan
};

}  // namespace swiftlet::sim
