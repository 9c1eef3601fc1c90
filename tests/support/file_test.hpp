// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "swiftlet/sim/errors/errors.hpp"
#include "tests/support/temporary_directory.hpp"

namespace swiftlet::sim {

/// Message of the InputError that a call throws.
template <class Call>
std::string refusal_of(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

/// A test with a folder for its files.
class FileTest : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }

  const TemporaryDirectory directory_;
  const std::filesystem::path folder_ = directory_.path();
};

}  // namespace swiftlet::sim
