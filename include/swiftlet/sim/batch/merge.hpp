// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace swiftlet::sim {

struct MergeOutcome {
  std::uint64_t episodes = 0;  ///< in the united database
  std::uint64_t expected = 0;  ///< of the whole batch
  std::uint64_t overlaps = 0;  ///< episodes that several sources had, and agreed on
  std::map<std::string, std::uint64_t> by_status;
  std::vector<std::uint64_t> first_missing;  ///< ten at most
};

/// The databases of `sources` (files, or directories with results.sqlite or shards/) in the order of their names.
/// Throws InputError.
std::vector<std::filesystem::path> find_databases(const std::vector<std::filesystem::path>& sources);

/// Unites databases of one batch in OUT/results.sqlite, which appears with its CSV files when it is complete. What an
/// earlier merge or a run left there takes part. The result does not depend on the order of the sources. Where several
/// have the same episode, one that is done wins over one that is not. Two that are done must agree in every number.
/// Throws InputError when they do not, when the sources belong to different batches, or while a batch writes there.
MergeOutcome merge_batches(const std::vector<std::filesystem::path>& databases, const std::filesystem::path& out);

}  // namespace swiftlet::sim
