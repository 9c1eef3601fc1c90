// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "swiftlet/core/map_voxels.hpp"

namespace swiftlet::sim {

/// Files of OctoMap's library: `.ot` holds the log-odds of every cell, `.bt` only whether it is occupied or free.
enum class OctomapFormat { kOt, kBt };

/// The content of such a file, written by the library. Maps whose values are no log-odds of OctoMap's
/// (MapVoxels::log_odds) tell by states. The first is free, those from `occupied_from` on are occupied, and the rest is
/// left out.
/// @param comments  lines of its header
std::string octomap_content(const MapVoxels& map, OctomapFormat format, const std::vector<std::string>& comments);

/// What such a file says, as centers of cells of its finest level. Any frame, the same for all arguments.
struct OctomapCells {
  double edge_m = 0.0;
  std::vector<Eigen::Vector3f> occupied_m, free_m;
};

/// Throws InputError naming the file and what is wrong with it.
/// @param require_bytes  asked before that much memory is taken
OctomapCells read_octomap(const std::filesystem::path& file, const std::function<void(double)>& require_bytes = {});
/// Does the name end as those of the library's files do?
bool is_octomap_file(const std::filesystem::path& file);

}  // namespace swiftlet::sim
