// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "swiftlet/sim/scenario/named_files.hpp"

namespace swiftlet::sim {

/// Output directory of a run, which gets its name only when it is complete. Until commit() its content lies in a
/// sibling directory `.NAME.partial-` with 16 hexadecimal digits. A killed run leaves no more than this directory
/// behind; the next run with the same destination removes it. A directory is removed only when it contains the lock
/// file of a run and no process holds the lock.
class RunDirectory {
 public:
  /// @param destination  may be an earlier run (a directory with a summary.json), which commit() replaces; InputError
  /// is thrown for any other nonempty directory or file
  /// @param inputs  files that the run reads; InputError is thrown for a file in the destination, which commit() would
  /// delete
  explicit RunDirectory(std::filesystem::path destination, std::span<const NamedFile> inputs = {});
  ~RunDirectory();  ///< removes the partial directory unless committed
  RunDirectory(const RunDirectory&) = delete;
  RunDirectory& operator=(const RunDirectory&) = delete;

  const std::filesystem::path& path() const { return partial_; }  ///< directory to write to
  const std::filesystem::path& destination() const { return destination_; }
  /// Moves the directory to its destination. Throws std::runtime_error when this fails. When another file or directory
  /// has appeared at the destination since the start, it is kept, the run is moved to DESTINATION.finished- with 16
  /// hexadecimal digits, and std::runtime_error is thrown too.
  void commit();

 private:
  void put_in_place();

  std::filesystem::path destination_;
  std::filesystem::path partial_;
  int lock_ = -1;  ///< descriptor of the lock file; negative where the file system has no locks
  bool committed_ = false;
};

}  // namespace swiftlet::sim
