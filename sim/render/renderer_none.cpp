// SPDX-License-Identifier: BSD-3-Clause
#include "sim/render/renderer.hpp"

// For a program without OpenGL (SWIFTLET_PICTURES=OFF). Cameras are rejected before a flight, see require_pictures().
namespace swiftlet::sim {

std::string_view picture_library() { return ""; }

struct Renderer::Impl {};

Renderer::Renderer(const Scene&, std::span<const std::shared_ptr<const VehicleShape>>) {
  require_pictures("pictures: ");
}
Renderer::~Renderer() = default;
Image Renderer::draw(const View&, const PictureScene&, const PictureStyle&) { return {}; }
DepthImage Renderer::draw_depth(const View&, const PictureScene&, const PictureStyle&) { return {}; }

}  // namespace swiftlet::sim
