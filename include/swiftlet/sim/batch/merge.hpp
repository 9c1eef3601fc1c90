// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace swiftlet::sim {

struct MergeOutcome {
  std::uint64_t episodes = 0;  ///< in the merged database
  std::uint64_t expected = 0;  ///< number of episodes of the whole batch
  std::uint64_t overlaps = 0;  ///< episodes present, with equal results, in several sources
  std::map<std::string, std::uint64_t> by_status;
  std::vector<std::uint64_t> first_missing;  ///< at most ten
};

/// The databases of `sources` (files, or directories with results.sqlite or shards/) in the order of their names.
/// Throws InputError.
std::vector<std::filesystem::path> find_databases(const std::vector<std::filesystem::path>& sources);

/// Merges databases of one batch into OUT/results.sqlite, which appears with its CSV files when it is complete. Results
/// of an earlier merge or run in OUT are merged too. The result does not depend on the order of the sources. Of several
/// rows of one episode, a done one replaces an unfinished one. Two done rows must agree in every number. Throws
/// InputError when they do not, when the sources belong to different batches, or while a batch writes to OUT.
MergeOutcome merge_batches(const std::vector<std::filesystem::path>& databases, const std::filesystem::path& out);

}  // namespace swiftlet::sim
