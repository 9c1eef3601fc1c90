// SPDX-License-Identifier: BSD-3-Clause
#include "swiftlet/core/math/ordered_product.hpp"

#include <gtest/gtest.h>

#include <array>
#include <new>

#include "swiftlet/core/math/random.hpp"

namespace swiftlet {
namespace {

template <int kRows, int kCols>
Eigen::Matrix<double, kRows, kCols> drawn(const Random& random, std::uint32_t tick) {
  Eigen::Matrix<double, kRows, kCols> M;
  for (int i = 0; i < M.size(); ++i) M(i) = random.normal(tick, static_cast<std::uint32_t>(i));
  return M;
}

/// The product with its sums from left to right, computed into memory `shift` doubles behind a multiple of 32 bytes.
template <int kRows, int kInner, int kCols>
void expect_ordered_sums() {
  const Random random(7, "product");
  const auto A = drawn<kRows, kInner>(random, 0);
  const auto B = drawn<kInner, kCols>(random, 1);
  using Product = Eigen::Matrix<double, kRows, kCols>;
  for (int shift = 0; shift < 4; ++shift) {
    alignas(32) std::array<double, kRows * kCols + 4> memory{};
    const auto* product = new (memory.data() + shift) Product(ordered_product(A, B));
    for (int i = 0; i < kRows; ++i) {
      for (int j = 0; j < kCols; ++j) {
        double sum = A(i, 0) * B(0, j);
        for (int k = 1; k < kInner; ++k) sum += A(i, k) * B(k, j);
        EXPECT_EQ((*product)(i, j), sum) << i << ", " << j << " of " << kRows << " x " << kCols << " at " << shift;
      }
    }
  }
}

TEST(OrderedProduct, IsBitwiseIdenticalAtEveryAddress) {
  expect_ordered_sums<3, 3, 3>();
  expect_ordered_sums<9, 9, 9>();
  expect_ordered_sums<9, 3, 9>();
  expect_ordered_sums<17, 17, 17>();
}

}  // namespace
}  // namespace swiftlet
