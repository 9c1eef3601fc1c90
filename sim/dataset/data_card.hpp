// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "swiftlet/sim/dataset/flight.hpp"
#include "swiftlet/sim/dataset/sequence_info.hpp"

namespace swiftlet::sim {

/// README.md with the dataset's statistics, its histograms (charts/*.svg) and its pictures.
void write_data_card(const DatasetPlan& plan, const std::vector<SequenceInfo>& sequences,
                     const std::filesystem::path& directory);

}  // namespace swiftlet::sim
