// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>

/// Whole files. A file has its name only when it is complete.
namespace swiftlet::sim {

/// A file that a library or another program writes: under a temporary name until commit() gives it its own. OutputFile
/// is made of it.
class PartialFile {
 public:
  PartialFile() = default;
  explicit PartialFile(std::filesystem::path destination);  ///< written as "DESTINATION.part"
  PartialFile(std::filesystem::path destination, std::filesystem::path partial);
  ~PartialFile();  ///< removes what was not committed
  PartialFile(PartialFile&& other) noexcept;
  PartialFile& operator=(PartialFile&& other) noexcept;

  const std::filesystem::path& destination() const { return destination_; }
  const std::filesystem::path& partial() const { return partial_; }
  /// Throws std::runtime_error "cannot write PATH: REASON".
  void commit();
  void abandon() noexcept;

 private:
  std::filesystem::path destination_, partial_;  // partial_ is empty when there is nothing to remove
};

/// Throws std::runtime_error "cannot write PATH: REASON".
[[noreturn]] void fail_to_write(const std::filesystem::path& path, const std::string& reason);
[[noreturn]] void fail_to_write(const std::filesystem::path& path, int error_number);

/// What becomes of a folder that is named but is not there.
enum class MissingFolders { kRefused, kMade };

/// Replaces the file. Throws std::runtime_error "cannot write PATH: REASON".
void write_file(const std::filesystem::path& path, std::string_view content,
                MissingFolders missing = MissingFolders::kRefused);

/// With its parents. Throws InputError when it cannot be made.
void make_directory(const std::filesystem::path& path);

/// A folder in an output directory. A link there, as an unpacked archive may hold, would lead the output elsewhere:
/// throws InputError, as make_directory() does.
void make_inner_directory(const std::filesystem::path& path);

/// Throws InputError unless it is a regular file that can be read. Opening a FIFO would wait for a writer for ever.
std::ifstream open_to_read(const std::filesystem::path& path);

/// "PATH: REASON" of an error of the file system, in place of the library's text.
std::string message_of(const std::filesystem::filesystem_error& error);

/// The whole file. Throws InputError when it cannot be read or is too large.
std::string read_whole_file(const std::filesystem::path& path);

}  // namespace swiftlet::sim
