// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/mappers/occupancy_mapper.hpp"

#include "core/mappers/near_cells.hpp"
#include "core/mappers/scan_rays.hpp"
#include "swiftlet/core/base/vehicle_named.hpp"
#include "swiftlet/core/localization/frame_change.hpp"
#include "swiftlet/core/messages/kind.hpp"
#include "swiftlet/core/messages/map_rays.hpp"

namespace swiftlet {
namespace {

class OccupancyMapper : public Mapper {
 public:
  OccupancyMapper(const OccupancyMapperConfig& config, const AgentSetup& setup)
      : config_(config),
        map_(make_occupancy_map(config.map)),
        scan_rays_({config.every_column, config.range_min_m, config.map.range_max_m, config.clear_range_m}),
        vehicles_(config.tracked_radius_m) {
    if (!config.rays_of.empty()) rays_of_ = vehicle_named(config.rays_of, setup, "mapping.rays_of");
    if (!config.send_rays_to.empty()) receiver_ = vehicle_named(config.send_rays_to, setup, "mapping.send_rays_to");
  }

  void step(const MapperInput& input, Outbox& outbox) override {
    p_local_m_ = input.estimate.T_local_body.translation();
    if (rays_of_ != kNoVehicle) {
      for (const Message& message : input.observation.messages) {
        if (message.from == rays_of_ && read_message(message, message_) == Reading::kDone) insert_received(input);
      }
      return;
    }
    vehicles_.update(input);
    for (const auto& cloud : input.clouds) {
      const std::span<const OccupancyMap::Ray> rays = scan_rays_.take(*cloud, vehicles_);
      map_->keep_around(p_local_m_);
      map_->insert(rays, cloud->end());
      if (receiver_ != kNoVehicle) send(rays, cloud->end(), FrameChange::to_world(input.estimate), outbox);
    }
  }

  const OccupancyView& map() const override { return *map_; }

  void append_counters(std::vector<Counter>& counters) const override { scan_rays_.append_counters(counters); }

  void append_overlays(std::vector<Overlay>& overlays) const override {
    overlays.push_back(near_cells(*map_, p_local_m_));
  }

 private:
  // Inserts the rays reported by another vehicle, without those that end on this vehicle.
  void insert_received(const MapperInput& input) {
    const FrameChange to_local = FrameChange::to_local(input.estimate);
    rays_.clear();
    for (const MapRay& ray : message_.rays) {
      const Eigen::Vector3f end_local_m = to_local.point(ray.end_world_m.cast<double>()).cast<float>();
      const bool is_self = ray.hit && (end_local_m.cast<double>() - p_local_m_).norm() < config_.tracked_radius_m;
      if (is_self) continue;
      rays_.push_back({to_local.point(ray.origin_world_m.cast<double>()).cast<float>(), end_local_m, ray.hit});
    }
    map_->keep_around(p_local_m_);
    map_->insert(rays_, message_.t);
  }

  void send(std::span<const OccupancyMap::Ray> rays, TimeNs t, const FrameChange& to_world, Outbox& outbox) {
    message_.t = t;
    message_.rays.clear();
    for (const OccupancyMap::Ray& ray : rays) {
      message_.rays.push_back({to_world.point(ray.origin_local_m.cast<double>()).cast<float>(),
                               to_world.point(ray.end_local_m.cast<double>()).cast<float>(), ray.hit});
    }
    write_message(message_, outbox.add(receiver_));
  }

  OccupancyMapperConfig config_;
  std::unique_ptr<OccupancyMap> map_;
  Vector3 p_local_m_ = Vector3::Zero();
  ScanRays scan_rays_;
  VehiclesAround vehicles_;
  std::vector<OccupancyMap::Ray> rays_;  // reported by another vehicle
  VehicleId rays_of_ = kNoVehicle, receiver_ = kNoVehicle;
  MapRays message_;
};

}  // namespace

void OccupancyMapperConfig::visit(ConfigVisitor& v) {
  v.field("every_column", every_column, "[-] every n-th column of a scan is used (paper: 4)", Range::between(1, 10000));
  v.field("range_min_m", range_min_m, "[m] range below which returns are of the own vehicle and ignored",
          Range::non_negative());
  v.field("clear_range_m", clear_range_m,
          "[m] length up to which beams without return clear cells; 0: such beams are ignored",
          Range::between(0.0, 1000.0));
  v.field("tracked_radius_m", tracked_radius_m,
          "[m] distance from another vehicle below which returns are ignored, extended by the uncertainty of its "
          "position; 0: "
          "none",
          Range::non_negative());
  v.field("rays_of", rays_of,
          "[-] name of the vehicle whose reported rays build the map; empty: the own LiDARs build it");
  v.field("send_rays_to", send_rays_to,
          "[-] name of a vehicle to which the rays of each scan are sent, in the world frame");
  map.visit(v);
  v.check(rays_of.empty() || send_rays_to.empty(), "send_rays_to", "empty if rays_of is set");
  v.check(clear_range_m <= map.range_max_m, "clear_range_m", "at most range_max_m");
}

std::unique_ptr<Mapper> make_occupancy_mapper(const ModuleConfig& config, const AgentSetup& setup) {
  return std::make_unique<OccupancyMapper>(dynamic_cast<const OccupancyMapperConfig&>(config), setup);
}

}  // namespace swiftlet
