// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "swiftlet/sim/world/scene.hpp"

namespace swiftlet::sim {

/// Writes the scene as `out` and its table of objects (for forests: the stem map) beside it as <stem>.objects.csv.
/// .ply: binary little-endian; each vertex carries color, class, instance, reflectivity and whether it is
/// retroreflective. .obj: one object <class>_<instance>_<mesh> with its material for each instance, and <stem>.mtl.
/// Each file appears complete under its name, or not at all. Returns the written paths.
/// Throws InputError for another extension, std::runtime_error when a file cannot be written.
std::vector<std::filesystem::path> export_world(const Scene& scene, const std::filesystem::path& out);

}  // namespace swiftlet::sim
