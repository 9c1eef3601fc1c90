// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "swiftlet/sim/report/batch_table.hpp"

namespace swiftlet::sim {

/// The page about a batch. It shows outcomes with Wilson's intervals, the telling metrics with box plots, sweeps and
/// paired differences, and every metric. The worst episodes and the failures follow with the commands that repeat them.
std::string batch_report_html(const BatchTable& table);

/// The numbers of that page, a row for every group with each of:
/// - a quantity: n, mean, sd, 95 % interval, order statistics, paired difference to the first variant;
/// - an outcome: rate, Wilson's interval, paired difference of the rates.
std::string batch_report_csv(const BatchTable& table);

/// Writes report.html and report.csv into a batch directory; their paths. Throws InputError when it is none.
std::vector<std::filesystem::path> write_batch_report(const std::filesystem::path& directory);

}  // namespace swiftlet::sim
