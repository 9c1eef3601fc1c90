// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "swiftlet/core/slam/saved_map.hpp"

namespace swiftlet::sim {

/// Version of the file format. Other versions cannot be read.
inline constexpr std::uint32_t kSlamMapVersion = 2;
inline constexpr std::string_view kSlamMapExtension = ".slam";

/// Serializes a SLAM map: a title, the version, size and checksum of the content, then pose graph and clouds. Numbers
/// are stored in their memory representation, so that reading restores every bit.
std::string slam_map_content(const SavedMap& map);
/// Reads a SLAM map. Throws InputError, with file and reason, if the file is missing, damaged or of another version.
SavedMap read_slam_map(const std::filesystem::path& file);
/// True if the name of the file ends with kSlamMapExtension.
bool is_slam_map_file(const std::filesystem::path& file);

}  // namespace swiftlet::sim
