#!/usr/bin/env bash
# Every installed header compiles by itself, with the installed package alone. Usage: headers_test.sh BUILD_DIR
set -euo pipefail
work=$1/headers_test
rm -rf "$work"
cmake --install "$1" --prefix "$work/prefix" >/dev/null

# Headers of Eigen and of the standard library are precompiled once for all.
cd "$work"/prefix/include/swiftlet-*
headers=$(find . -name '*.hpp' | sed 's,^\./,,' | sort)
options="-std=c++20 -Werror -Wno-ignored-attributes -I. $(pkg-config --cflags eigen3)"
printf '#include <%s>\n' Eigen/Geometry filesystem functional map memory optional span string vector >"$work/common.hpp"
c++ $options -x c++-header "$work/common.hpp" -o "$work/common.hpp.gch"
alone="echo \"#include \\\"\$1\\\"\" | c++ $options -include '$work/common.hpp' -fsyntax-only -x c++ - ||
  { echo \"\$1 does not stand alone\"; exit 1; }"
echo "$headers" | xargs -P "$(nproc)" -I HEADER sh -c "$alone" sh HEADER
echo "$(echo "$headers" | wc -l) headers stand alone"
