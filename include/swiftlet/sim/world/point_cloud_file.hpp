// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace swiftlet::sim {

/// Reads x, y, z of every point with finite coordinates. PCD v0.7 (ascii, binary, binary_compressed) and PLY (ascii,
/// binary of either byte order). Throws InputError naming the file and the fault.
std::vector<Eigen::Vector3d> read_point_cloud(const std::filesystem::path& file);

/// LZF (Marc Lehmann's liblzf), the compression of PCD. Returns false unless the input gives exactly out.size() bytes.
bool decompress_lzf(std::string_view in, std::string& out);

}  // namespace swiftlet::sim
