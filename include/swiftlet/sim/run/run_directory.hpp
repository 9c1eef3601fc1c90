// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "swiftlet/sim/scenario/named_files.hpp"

namespace swiftlet::sim {

/// A directory that appears under its name only when it is complete. Until commit() its content lies in a sibling
/// directory `.NAME.partial-` with 16 hexadecimal digits. A killed run leaves at most that, and the next run of the
/// same name removes it. A directory is removed only when it contains the lock file of a run and no process holds the
/// lock.
class RunDirectory {
 public:
  /// @param destination  an earlier run there (a directory with a summary.json) is replaced at commit(); any other
  /// nonempty destination throws InputError
  /// @param inputs  files that the run reads; throws InputError if one lies in the destination, which would delete it
  explicit RunDirectory(std::filesystem::path destination, std::span<const NamedFile> inputs = {});
  ~RunDirectory();  ///< without commit(): removes the partial directory
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;

  const std::filesystem::path& path() const { return partial_; }  ///< where to write
  const std::filesystem::path& destination() const { return destination_; }
  /// Moves it to its destination. If a file or directory has appeared there meanwhile, that is kept and the run gets
  /// another name. Throws std::runtime_error in that case, and when it cannot be moved.
  void commit();

 private:
  void put_in_place();

  std::filesystem::path destination_;
  std::filesystem::path partial_;
  int lock_ = -1;  ///< descriptor of the lock file; negative where the file system has no locks
  bool committed_ = false;
};

}  // namespace swiftlet::sim
