// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace swiftlet::sim {

struct VerifyOptions {
  int frames = 3;                  ///< number of frames to re-simulate; 0: none
  std::uint64_t seed = 0;          ///< seed of the random choice of those frames
  std::function<bool()> canceled;  ///< called between files and ticks; true ends the verification early
  std::function<void(double done, const std::string& note)> progress;  ///< `done` from 0 to 1
};

struct VerifyReport {
  std::int64_t files = 0;             ///< files with compared hashes
  std::int64_t frames = 0;            ///< frames with checked layout
  int resimulated = 0;                ///< frames compared bit for bit
  std::vector<std::string> problems;  ///< one line each; empty: the dataset is valid
  std::string poses_outside;          ///< see poses_outside() in sequence_info.hpp; empty where walls enclose no ground

  bool ok() const { return problems.empty(); }
};

/// Checks a dataset:
/// - All files are present with correct sizes and hashes, and there are no unexpected files.
/// - Every sequence has as many poses, times, scans and labels as frames, labels of the class table, and boxes of its
///   frames.
/// - Random frames are equal, bit for bit, when their flight is simulated again.
///
/// Throws InputError when the directory holds no dataset.
VerifyReport verify_dataset(const std::filesystem::path& directory, const VerifyOptions& options);

}  // namespace swiftlet::sim
