// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "sim/render/image.hpp"

namespace swiftlet::sim {

/// Writes an 8-bit RGB PNG, optimized for speed, under a temporary name that is renamed when complete.
/// Throws std::runtime_error with path and reason.
/// @param dpi  pixels per 25.4 mm when printed, stored in the file; 0: not stored
void write_png(const std::filesystem::path& path, const Image& image, double dpi = 0.0);

/// The PNG file in memory, with better compression.
std::string png_of(const Image& image);

/// As write_png() for 16-bit gray, row 0 on top.
void write_png16(const std::filesystem::path& path, int width, int height, std::span<const std::uint16_t> gray);

}  // namespace swiftlet::sim
