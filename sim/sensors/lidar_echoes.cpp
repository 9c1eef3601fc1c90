// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sensors/lidar_echoes.hpp"

#include <cmath>
#include <limits>

#include "swiftlet/core/math/angles.hpp"

namespace swiftlet::sim {
namespace {

// [-] Largest number of rays that represent one beam; the size of the arrays of an echo.
constexpr int kMaxSubRays = 9;

}  // namespace

EchoTracer::EchoTracer(const LidarConfig& config, const SweepScene& scene, std::vector<SurfaceLookUp> surfaces)
    : scene_(scene),
      surfaces_(std::move(surfaces)),
      sub_rays_(sub_rays(config.ideal ? 1 : config.beam.sub_rays)),
      // FWHM of a Gaussian = 2 sqrt(2 ln 2) sigma.
      sub_ray_sigma_rad_(static_cast<float>(config.beam.divergence_deg * kRadPerDeg / 2.354820045)),
      pulse_m_(static_cast<float>(config.beam.pulse_length_m)),
      retro_gain_(static_cast<float>(config.detection.retro_gain)) {}

// Cubature of a plane Gaussian: 5 points exact to degree 3 (and 4 on the axes), 9 points of the Gauss-Hermite product.
std::vector<EchoTracer::SubRay> EchoTracer::sub_rays(int count) {
  const float a = std::sqrt(3.0F);
  std::vector<SubRay> rays = {{0, 0, 1}};
  if (count == 5) rays = {{0, 0, 1.0F / 3}, {a, 0, 1.0F / 6}, {-a, 0, 1.0F / 6}, {0, a, 1.0F / 6}, {0, -a, 1.0F / 6}};
  if (count == 9) {
    rays.clear();
    for (const int i : {0, 1, -1}) {
      for (const int j : {0, 1, -1}) {
        rays.push_back({i * a, j * a, (i == 0 ? 2.0F / 3 : 1.0F / 6) * (j == 0 ? 2.0F / 3 : 1.0F / 6)});
      }
    }
  }
  return rays;
}

// Beams rotated by the small angles of a sub-ray: `across` to the left, `up` upwards.
BeamPacket EchoTracer::turned(const BeamPacket& beams, const SubRay& ray) const {
  const float across_rad = ray.across * sub_ray_sigma_rad_, up_rad = ray.up * sub_ray_sigma_rad_;
  BeamPacket out = beams;
  for (int i = 0; i < kPacketSize; ++i) {
    const float x = beams.direction_x[i], y = beams.direction_y[i], z = beams.direction_z[i];
    const float level = std::sqrt(x * x + y * y);
    // Left is horizontal; for vertical beams any horizontal direction serves.
    const float left_x = level > 1e-6F ? -y / level : 0.0F;
    const float left_y = level > 1e-6F ? x / level : 1.0F;
    const float up_x = -z * left_y, up_y = z * left_x, up_z = x * left_y - y * left_x;
    const float dx = x + across_rad * left_x + up_rad * up_x;
    const float dy = y + across_rad * left_y + up_rad * up_y;
    const float dz = z + up_rad * up_z;
    const float scale = 1.0F / std::sqrt(dx * dx + dy * dy + dz * dz);
    out.direction_x[i] = scale * dx;
    out.direction_y[i] = scale * dy;
    out.direction_z[i] = scale * dz;
  }
  return out;
}

std::uint32_t EchoTracer::reaches_self(const BeamPacket& beams) const {
  std::uint32_t reaches = 0;
  for (const SubRay& ray : sub_rays_) {
    const bool is_axis = ray.across == 0.0F && ray.up == 0.0F;
    reaches |= scene_.reaches_self(is_axis ? beams : turned(beams, ray));
  }
  return reaches;
}

float EchoTracer::brightness(std::uint32_t surface, float cos_incidence) const {
  const SurfaceLookUp& s = surfaces_[surface];
  return s.retroreflective ? s.reflectivity * retro_gain_ : s.reflectivity * cos_incidence;
}

void EchoTracer::trace_thin(const LidarTile& tile, Echoes& echoes) const {
  PacketHits hits;
  scene_.trace(tile.beams, tile.meets_self, hits);
  echoes.range_m = hits.range_m;
  echoes.cos_incidence = hits.cos_incidence;
  echoes.surface = hits.surface;
  for (int i = 0; i < kPacketSize; ++i) echoes.brightness[i] = brightness(hits.surface[i], hits.cos_incidence[i]);
}

// Echoes of sub-rays within one pulse length merge into one; the strongest merged echo is returned.
void EchoTracer::trace_wide(const LidarTile& tile, Echoes& echoes) const {
  const int count = static_cast<int>(sub_rays_.size());
  std::array<PacketHits, kMaxSubRays> hits;
  for (int k = 0; k < count; ++k) {
    scene_.trace(turned(tile.beams, sub_rays_[k]), tile.meets_self, hits[k]);
  }
  for (int i = 0; i < kPacketSize; ++i) {
    std::array<float, kMaxSubRays> bright{}, power{};
    for (int k = 0; k < count; ++k) {
      const float range = hits[k].range_m[i];
      if (range <= 0.0F) continue;
      bright[k] = sub_rays_[k].weight * brightness(hits[k].surface[i], hits[k].cos_incidence[i]);
      power[k] = bright[k] / (range * range) + std::numeric_limits<float>::min();  // > 0: the sub-ray meets a surface
    }
    echoes.range_m[i] = echoes.cos_incidence[i] = echoes.brightness[i] = 0.0F;
    echoes.surface[i] = 0;
    float strongest = 0.0F;
    for (int first = 0; first < count; ++first) {
      if (power[first] == 0.0F) continue;
      float sum_power = 0.0F, sum_range = 0.0F, sum_bright = 0.0F;
      int brightest = first;
      for (int k = 0; k < count; ++k) {
        const float behind = hits[k].range_m[i] - hits[first].range_m[i];
        if (power[k] == 0.0F || behind < 0.0F || behind > pulse_m_) continue;
        sum_power += power[k];
        sum_range += power[k] * behind;
        sum_bright += bright[k];
        if (power[k] > power[brightest]) brightest = k;
      }
      if (sum_power <= strongest) continue;
      strongest = sum_power;
      echoes.range_m[i] = hits[first].range_m[i] + sum_range / sum_power;
      echoes.brightness[i] = sum_bright;
      echoes.cos_incidence[i] = hits[brightest].cos_incidence[i];
      echoes.surface[i] = hits[brightest].surface[i];
    }
  }
}

}  // namespace swiftlet::sim
