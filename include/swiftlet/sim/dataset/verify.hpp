// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace swiftlet::sim {

struct VerifyOptions {
  int frames = 3;          ///< to re-simulate; 0: none
  std::uint64_t seed = 0;  ///< which ones
  std::function<bool()> canceled;
  std::function<void(double done, const std::string& note)> progress;
};

struct VerifyReport {
  std::int64_t files = 0;             ///< whose hash was compared
  std::int64_t frames = 0;            ///< whose layout was checked
  int resimulated = 0;                ///< frames compared bit for bit
  std::vector<std::string> problems;  ///< one line each; empty: all is well
  std::string poses_outside;          ///< as in the data card; empty where walls enclose no ground

  bool ok() const { return problems.empty(); }
};

/// Checks a dataset:
/// - It is complete, every file has its size and hash, and nothing is there that should not be.
/// - Every sequence has as many poses, times, scans and labels as frames, labels of the class table, and boxes of its
///   frames.
/// - Random frames come out the same, bit for bit, when their flight is simulated again.
///
/// Throws InputError when the directory holds no dataset.
VerifyReport verify_dataset(const std::filesystem::path& directory, const VerifyOptions& options);

}  // namespace swiftlet::sim
