// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/sim/io/base64.hpp"

#include <gtest/gtest.h>

#include <string>

namespace swiftlet::sim {
namespace {

TEST(Base64, IsThatOfRfc4648) {
  // The vectors of its section 10.
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

TEST(Base64, KeepsBytesThatAreNoText) {
  EXPECT_EQ(base64(std::string("\x00\xff\xfe", 3)), "AP/+");
  EXPECT_EQ(base64(std::string("\xfb\xef\xbe\xff", 4)), "++++/w==");
}

}  // namespace
}  // namespace swiftlet::sim
