// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "swiftlet/sim/report/batch_table.hpp"

namespace swiftlet::sim {

/// The page about a batch. It shows outcomes with Wilson's intervals, the telling metrics with box plots, sweeps and
/// paired differences, and every metric. The worst episodes and the failures follow with the commands that repeat them.
/// Replays of the worst ones that lie in the batch directory can be opened in it.
std::string batch_report_html(const BatchTable& table, const std::filesystem::path& directory = {});

/// The episodes that the page calls worst, the worst first, at most so many.
std::vector<EpisodeRow> worst_episodes(const BatchTable& table, std::size_t count);

/// The run directory of an episode's replay, within the batch directory.
std::filesystem::path replay_of_episode(std::uint64_t id);

/// Does a replay lie there that is of this very flight, by its state hash?
bool has_replay(const std::filesystem::path& directory, const EpisodeRow& row);

/// The numbers of that page, a row for every group with each of:
/// - a quantity: n, mean, sd, 95 % interval, order statistics, paired difference to the first variant;
/// - an outcome: rate, Wilson's interval, paired difference of the rates.
std::string batch_report_csv(const BatchTable& table);

/// Writes report.html and report.csv into a batch directory; their paths. Throws InputError when it is none.
std::vector<std::filesystem::path> write_batch_report(const std::filesystem::path& directory);

}  // namespace swiftlet::sim
