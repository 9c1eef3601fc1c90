// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/core/base/map_voxels.hpp"

namespace swiftlet::sim {

/// Files of the OctoMap library: `.ot` holds the log-odds of every cell, `.bt` only occupied or free.
enum class OctomapFormat { kOt, kBt };

/// The content of such a file, written by the library. Maps without log-odds of OctoMap (MapVoxels::log_odds) are
/// written by voxel state: the first state is free, those from `occupied_from` on are occupied, and all others are
/// omitted.
/// @param comments  comment lines of the header
std::string octomap_content(const MapVoxels& map, OctomapFormat format, const std::vector<std::string>& comments);

/// Cells of such a file, as centers at its finest resolution. Any frame, the same for all arguments.
struct OctomapCells {
  double edge_m = 0.0;
  std::vector<Eigen::Vector3f> occupied_m, free_m;
};

/// Throws InputError naming the file and the fault.
/// @param require_bytes  called with the needed memory before it is allocated; may throw
OctomapCells read_octomap(const std::filesystem::path& file, const std::function<void(double)>& require_bytes = {});
/// True for a name with an extension of these formats.
bool is_octomap_file(const std::filesystem::path& file);

}  // namespace swiftlet::sim
