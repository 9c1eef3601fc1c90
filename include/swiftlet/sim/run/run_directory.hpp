// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "swiftlet/sim/scenario/named_files.hpp"

namespace swiftlet::sim {

/// A directory that appears under its name only when it is complete. Until commit() everything lies beside it in
/// `.NAME.partial-` with 16 hexadecimal digits. A killed run leaves at most that, and the next run of the same name
/// removes it. A directory is removed only when it holds the lock file of a run and no process holds the lock.
class RunDirectory {
 public:
  /// @param destination  an earlier run there (a directory with a summary.json) is replaced at commit(); anything else
  ///                     that is not an empty directory throws InputError
  /// @param inputs  what the run reads; one that lies in the destination would be lost with it: throws InputError
  explicit RunDirectory(std::filesystem::path destination, std::span<const NamedFile> inputs = {});
  ~RunDirectory();  ///< without commit(): removes what was written
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;

  const std::filesystem::path& path() const { return partial_; }  ///< where to write
  const std::filesystem::path& destination() const { return destination_; }
  /// Moves it to its destination. What appeared there meanwhile stays, and the run gets another name: that, and what
  /// cannot be moved, throws std::runtime_error.
  void commit();

 private:
  void put_in_place();

  std::filesystem::path destination_;
  std::filesystem::path partial_;
  int lock_ = -1;  ///< descriptor of the lock file; below 0 where the file system has no locks
  bool committed_ = false;
};

}  // namespace swiftlet::sim
