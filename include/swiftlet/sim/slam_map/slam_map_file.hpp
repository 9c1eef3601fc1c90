// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "swiftlet/core/slam/saved_map.hpp"

namespace swiftlet::sim {

/// Version of the files that this program writes, and the only one that it reads.
inline constexpr std::uint32_t kSlamMapVersion = 2;
inline constexpr std::string_view kSlamMapExtension = ".slam";

/// A map of SLAM as one file: a title, the version, the size and the checksum of what follows, then graph and clouds.
/// All numbers as they stand in memory, so that a map that is read is the one that was written, to the last bit.
std::string slam_map_content(const SavedMap& map);
/// Throws InputError naming the file and what is wrong with it.
SavedMap read_slam_map(const std::filesystem::path& file);
/// Does the name end as those of such files do?
bool is_slam_map_file(const std::filesystem::path& file);

}  // namespace swiftlet::sim
