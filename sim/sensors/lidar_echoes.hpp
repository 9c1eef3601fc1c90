// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/sensors/lidar_tiles.hpp"
#include "swiftlet/sim/raycast/sweep_scene.hpp"
#include "swiftlet/sim/sensors/lidar.hpp"

namespace swiftlet::sim {

/// Properties of a surface for the measurement, besides its truth labels.
struct SurfaceLookUp {
  float reflectivity = 0.0F;
  bool retroreflective = false;
  std::uint8_t part = 0;
  std::uint16_t surface_class = 0;
  std::uint16_t instance = 0;
};

/// One echo per beam of a packet. The brightness is reflectivity * cos(incidence), summed over the beam's
/// cross-section.
struct alignas(64) Echoes {
  std::array<float, kPacketSize> range_m;  // 0: none
  std::array<float, kPacketSize> cos_incidence;
  std::array<float, kPacketSize> brightness;
  std::array<std::uint32_t, kPacketSize> surface;
};

/// The echoes that the beams of a LiDAR receive from a scene. Thread-safe.
class EchoTracer {
 public:
  /// @param scene  must outlive the tracer  @param surfaces  indexed by surface number of the scene
  EchoTracer(const LidarConfig& config, const SweepScene& scene, std::vector<SurfaceLookUp> surfaces);

  void trace(const LidarTile& tile, Echoes& echoes) const {
    sub_rays_.size() == 1 ? trace_thin(tile, echoes) : trace_wide(tile, echoes);
  }
  /// Bit i: the cross-section of beam i can intersect the own vehicle.
  std::uint32_t reaches_self(const BeamPacket& beams) const;
  const SurfaceLookUp& surface(std::uint32_t number) const { return surfaces_[number]; }

 private:
  /// A sample of the beam's cross-section, in standard deviations of its Gaussian profile.
  struct SubRay {
    float across, up, weight;
  };
  static std::vector<SubRay> sub_rays(int count);

  void trace_thin(const LidarTile& tile, Echoes& echoes) const;
  void trace_wide(const LidarTile& tile, Echoes& echoes) const;
  BeamPacket turned(const BeamPacket& beams, const SubRay& ray) const;
  float brightness(std::uint32_t surface, float cos_incidence) const;

  const SweepScene& scene_;
  std::vector<SurfaceLookUp> surfaces_;
  std::vector<SubRay> sub_rays_;
  float sub_ray_sigma_rad_;
  float pulse_m_;
  float retro_gain_;
};

}  // namespace swiftlet::sim
