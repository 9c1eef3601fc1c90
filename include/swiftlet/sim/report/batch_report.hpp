// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "swiftlet/sim/report/batch_table.hpp"

namespace swiftlet::sim {

/// The report page of a batch. It shows outcomes with Wilson's intervals, the selected quantities with box plots,
/// sweeps and paired differences, and every metric. The worst episodes and the failures follow with the commands that
/// repeat them. Replays of the worst episodes in the batch directory are linked.
std::string batch_report_html(const BatchTable& table, const std::filesystem::path& directory = {});

/// The episodes listed as worst on the page, worst first, at most `count`.
std::vector<EpisodeRow> worst_episodes(const BatchTable& table, std::size_t count);

/// The run directory of an episode's replay, within the batch directory.
std::filesystem::path replay_of_episode(std::uint64_t id);

/// True if the directory contains a replay of the flight with this state hash.
bool has_replay(const std::filesystem::path& directory, const EpisodeRow& row);

/// The numbers of that page, with a row for every group and each:
/// - quantity: n, mean, sd, 95 % interval, order statistics, paired difference to the first variant;
/// - outcome: rate, Wilson's interval, paired difference of the rates.
std::string batch_report_csv(const BatchTable& table);

/// Writes report.html and report.csv into a batch directory and returns their paths. Throws InputError for any other
/// directory.
std::vector<std::filesystem::path> write_batch_report(const std::filesystem::path& directory);

}  // namespace swiftlet::sim
