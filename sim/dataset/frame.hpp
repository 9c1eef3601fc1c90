// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "swiftlet/sim/dataset/dataset_config.hpp"
#include "swiftlet/sim/io/byte_buffer.hpp"
#include "swiftlet/sim/world/labeled_scan.hpp"

namespace swiftlet::sim {

/// One scan in the layout of SemanticKITTI (little-endian), and data beyond that layout. All arrays contain the same
/// points in the same order: the returns, row by row.
struct Frame {
  ByteBuffer velodyne;     ///< float32 x, y, z [m], remission
  ByteBuffer labels;       ///< uint32: class in the low 16 bits, instance in the high 16
  ByteBuffer point_truth;  ///< packed: uint32 t_ns, uint16 ring, uint16 column, float32 range_m, float32 incidence_rad
  int num_points = 0;
};
/// [bytes] Size of the entry of a point in Frame::velodyne, Frame::labels and Frame::point_truth.
inline constexpr std::size_t kPointBytes = 16;
inline constexpr std::size_t kLabelBytes = 4;
inline constexpr std::size_t kPointTruthBytes = 16;

/// A pure function of the scan; reuses the memory of `frame`.
void encode_frame(const LabeledScan& scan, const ContentConfig& content, Frame& frame);

/// Range and intensity images by row and column, as fired (see pixel_shift_by_row). 0: no return.
void encode_images(const LabeledScan& scan, const ContentConfig& content, std::vector<std::uint16_t>& range,
                   std::vector<std::uint16_t>& intensity);

/// True if the rows and columns of the scan form an image.
bool is_image_shaped(const Scan& scan);

/// Number of columns by which each row must be shifted to the right so that pixels of one column have the same azimuth.
std::vector<int> pixel_shift_by_row(const BeamTable& beams);

}  // namespace swiftlet::sim
