// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "swiftlet/sim/batch/batch_config.hpp"
#include "swiftlet/sim/scenario/reference.hpp"

namespace swiftlet::sim {
namespace {

TEST(BatchReference, TheDocumentIsUpToDate) {
  BatchConfig config;
  const std::string tables = reference_tables([&](ConfigVisitor& v) { config.visit(v); }, "Every key of a batch file");
  std::ifstream file(SWIFTLET_SOURCE_DIR "/docs/batch.md");
  const std::string document((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(document.find(tables), std::string::npos) << "docs/batch.md should end with\n" << tables;
}

}  // namespace
}  // namespace swiftlet::sim
