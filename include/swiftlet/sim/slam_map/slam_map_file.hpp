// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "swiftlet/core/slam/saved_map.hpp"

namespace swiftlet::sim {

/// File version written by this program, and the only one that it reads.
inline constexpr std::uint32_t kSlamMapVersion = 2;
inline constexpr std::string_view kSlamMapExtension = ".slam";

/// A SLAM map as one file: a title, the version, size and checksum of the content, then graph and clouds. Numbers are
/// stored in their memory representation, so that reading restores every bit.
std::string slam_map_content(const SavedMap& map);
/// Throws InputError naming the file and the fault.
SavedMap read_slam_map(const std::filesystem::path& file);
/// True for a name with the extension of these files.
bool is_slam_map_file(const std::filesystem::path& file);

}  // namespace swiftlet::sim
