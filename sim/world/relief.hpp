// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "swiftlet/core/math/random.hpp"
#include "swiftlet/sim/world/relief_config.hpp"
#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Smooth ground: value noise in octaves (each of half the wavelength and half the height), |height| <= amplitude.
class Relief {
 public:
  Relief(const ReliefConfig& config, std::uint64_t seed);
  double height_m(double x_m, double y_m) const;

 private:
  ReliefConfig config_;
  Random random_;
};

/// The rectangle of ground as a triangle mesh; a flat one has two triangles.
Mesh make_ground(const Relief& relief, bool flat, const Eigen::Vector2d& min_world_m,
                 const Eigen::Vector2d& max_world_m, double cell_m);

/// The ground around that rectangle, out to `width_m`, with triangles that grow outward. Both meshes share their edge.
Mesh make_ground_around(const Relief& relief, bool flat, const Eigen::Vector2d& min_world_m,
                        const Eigen::Vector2d& max_world_m, double cell_m, double width_m);

}  // namespace swiftlet::sim
