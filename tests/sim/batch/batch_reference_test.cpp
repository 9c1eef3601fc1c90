// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "swiftlet/sim/batch/batch_config.hpp"
#include "swiftlet/sim/io/files.hpp"
#include "swiftlet/sim/scenario/reference.hpp"
#include "tests/support/numeric_bounds.hpp"

namespace swiftlet::sim {
namespace {

TEST(BatchReference, NumericKeysAcceptExactlyTheirBounds) {
  std::size_t num_keys = 0;
  const auto visit = [](ConfigVisitor& v) {
    BatchConfig fresh;
    fresh.visit(v);
  };
  EXPECT_THAT(testing::wrong_bounds(visit, num_keys), ::testing::IsEmpty());
  EXPECT_GT(num_keys, 10U);
}

TEST(BatchReference, TheDocumentIsUpToDate) {
  BatchConfig config;
  const std::string tables = reference_tables([&](ConfigVisitor& v) { config.visit(v); }, "Every key of a batch file");
  const std::string document = read_whole_file(SWIFTLET_SOURCE_DIR "/docs/batch.md");
  EXPECT_NE(document.find(tables), std::string::npos) << "docs/batch.md should end with\n" << tables;
}

}  // namespace
}  // namespace swiftlet::sim
