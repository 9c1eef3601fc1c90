// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// A scene for display with about `most_triangles` triangles, without instancing. To reduce triangles, plants lose
/// leaves while the remaining ones grow, and all other meshes are coarsened. Meshes and instances keep their numbers.
Scene thinned_scene(const Scene& scene, std::size_t most_triangles);

/// Leaves and branches: a mesh of many small pieces.
bool is_plant(const Mesh& mesh);

}  // namespace swiftlet::sim
