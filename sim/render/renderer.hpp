// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "sim/render/cameras.hpp"
#include "sim/render/image.hpp"
#include "sim/render/picture_scene.hpp"
#include "sim/render/picture_style.hpp"
#include "swiftlet/sim/world/scene.hpp"
#include "swiftlet/sim/world/vehicle_shape.hpp"

namespace swiftlet::sim {

/// Draws pictures of one world and its vehicles in software. The world is uploaded once. Equal inputs give equal pixels
/// on one machine. May be used by different threads, but only one at a time.
class Renderer {
 public:
  /// Throws std::runtime_error when no OpenGL context is available.
  Renderer(const Scene& scene, std::span<const std::shared_ptr<const VehicleShape>> vehicle_shapes);
  ~Renderer();

  Image draw(const View& view, const PictureScene& picture, const PictureStyle& style);
  /// Depth of world and vehicles along the optical axis.
  DepthImage draw_depth(const View& view, const PictureScene& picture, const PictureStyle& style);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace swiftlet::sim
