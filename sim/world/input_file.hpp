// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

/// Reading files that others wrote: everything that can be wrong with them ends in one clear line.
namespace swiftlet::sim {

/// Throws InputError: "<file>: <reason>".
[[noreturn]] void reject_file(const std::filesystem::path& file, const std::string& reason);

/// The extension in lower case without its dot.
std::string extension_of(const std::filesystem::path& file);

}  // namespace swiftlet::sim
