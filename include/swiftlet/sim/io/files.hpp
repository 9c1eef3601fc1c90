// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>

/// Reading and writing of whole files. A file appears under its name only when it is complete.
namespace swiftlet::sim {

/// A file written by a library or another program: under a temporary name until commit() renames it. OutputFile is
/// built on it.
class PartialFile {
 public:
  PartialFile() = default;
  explicit PartialFile(std::filesystem::path destination);  ///< written as "DESTINATION.part"
  PartialFile(std::filesystem::path destination, std::filesystem::path partial);
  ~PartialFile();  ///< removes an uncommitted file
  PartialFile(PartialFile&& other) noexcept;
  PartialFile& operator=(PartialFile&& other) noexcept;

  const std::filesystem::path& destination() const { return destination_; }
  const std::filesystem::path& partial() const { return partial_; }
  /// Throws std::runtime_error "cannot write PATH: REASON".
  void commit();
  void abandon() noexcept;

 private:
  std::filesystem::path destination_, partial_;  // partial_ is empty when there is no file to remove
};

/// Throws std::runtime_error "cannot write PATH: REASON".
[[noreturn]] void fail_to_write(const std::filesystem::path& path, const std::string& reason);
[[noreturn]] void fail_to_write(const std::filesystem::path& path, int error_number);

/// Handling of a missing folder in the path of a file to write.
enum class MissingFolders { kRefused, kMade };

/// Replaces the file. Throws std::runtime_error "cannot write PATH: REASON".
void write_file(const std::filesystem::path& path, std::string_view content,
                MissingFolders missing = MissingFolders::kRefused);

/// Also creates its parents. Throws InputError when it cannot be created.
void make_directory(const std::filesystem::path& path);

/// Creates a folder in an output directory. Throws InputError where a link already has this name (an unpacked archive
/// may contain one), since it would redirect the output; otherwise as make_directory().
void make_inner_directory(const std::filesystem::path& path);

/// Throws InputError unless it is a regular, readable file. Opening a FIFO would block until a writer opens it.
std::ifstream open_to_read(const std::filesystem::path& path);

/// "PATH: REASON" of a file system error, instead of the library's text.
std::string message_of(const std::filesystem::filesystem_error& error);

/// Content of the file. Throws InputError when it cannot be read or is too large.
std::string read_whole_file(const std::filesystem::path& path);

}  // namespace swiftlet::sim
