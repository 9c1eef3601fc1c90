// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/io/files.hpp"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "swiftlet/sim/errors/errors.hpp"
#include "swiftlet/sim/io/output_file.hpp"

namespace swiftlet::sim {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{4} << 30;

}  // namespace

PartialFile::PartialFile(fs::path destination) : destination_(std::move(destination)) {
  partial_ = destination_.string() + ".part";
}

PartialFile::PartialFile(fs::path destination, fs::path partial)
    : destination_(std::move(destination)), partial_(std::move(partial)) {}

PartialFile::~PartialFile() { abandon(); }

PartialFile::PartialFile(PartialFile&& other) noexcept { *this = std::move(other); }

PartialFile& PartialFile::operator=(PartialFile&& other) noexcept {
  if (this == &other) return *this;
  abandon();
  destination_ = std::move(other.destination_);
  partial_ = std::exchange(other.partial_, {});
  return *this;
}

void PartialFile::commit() {
  std::error_code error;
  fs::rename(partial_, destination_, error);
  if (error) fail_to_write(destination_, error.message());
  partial_.clear();
}

void PartialFile::abandon() noexcept {
  if (partial_.empty()) return;
  std::error_code ignored;
  fs::remove(partial_, ignored);
  partial_.clear();
}

void fail_to_write(const fs::path& path, const std::string& reason) {
  throw std::runtime_error("cannot write " + path.string() + ": " + reason);
}

void fail_to_write(const fs::path& path, int error_number) { fail_to_write(path, std::strerror(error_number)); }

void write_file(const fs::path& path, std::string_view content, MissingFolders missing) {
  OutputFile file(path, 0, missing);
  file.append(content);
  file.finish();
}

void make_directory(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error) return;
  std::error_code missing;
  const bool is_dangling = fs::is_symlink(path, missing) && !fs::exists(path, missing);
  throw InputError(path.string() + ": expected a directory that can be made, found: " +
                   (is_dangling ? "a link to " + fs::read_symlink(path, missing).string() + ", which is not there"
                                : error.message()));
}

void make_inner_directory(const fs::path& path) {
  std::error_code error;
  if (fs::is_symlink(path, error)) {
    throw InputError(path.string() +
                     ": expected a folder or nothing, found a link; remove it, because output does not follow links");
  }
  make_directory(path);
}

std::ifstream open_to_read(const fs::path& path) {
  errno = 0;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) throw InputError("cannot read " + path.string() + ": is a directory");
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw InputError("cannot read " + path.string() + ": expected a regular file, found a pipe, socket or device");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError("cannot read " + path.string() + ": " + std::strerror(errno));
  return stream;
}

std::string message_of(const fs::filesystem_error& error) {
  return (error.path2().empty() ? error.path1() : error.path2()).string() + ": " + error.code().message();
}

std::string read_whole_file(const fs::path& path) {
  std::ifstream stream = open_to_read(path);
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) throw InputError("cannot read " + path.string() + ": " + error.message());
  if (size > kMaxFileBytes) {
    throw InputError(path.string() + ": expected at most 4 GiB, found " + std::to_string(size) + " bytes");
  }
  std::string content(size, '\0');
  stream.read(content.data(), static_cast<std::streamsize>(size));
  if (static_cast<std::uintmax_t>(stream.gcount()) != size)
    throw InputError("cannot read " + path.string() + ": it ends early");
  return content;
}

}  // namespace swiftlet::sim
