#!/usr/bin/env bash
# The Debian package of the program holds all that it needs. Usage: package_test.sh BUILD_DIR
set -euo pipefail
build=$(cd "$1" && pwd)
command -v dpkg-shlibdeps >/dev/null || { echo "skipped: dpkg-dev is not installed"; exit 77; }
work=$build/package_test
rm -rf "$work"
mkdir -p "$work/elsewhere"
cpack -G DEB --config "$build/CPackConfig.cmake" -B "$work" -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip >"$work/log" 2>&1 ||
  { cat "$work/log"; exit 1; }
package=$(echo "$work"/swiftlet_*.deb)
dpkg-deb -x "$package" "$work/root"
depends=$(dpkg-deb -f "$package" Depends)
for library in libembree libbullet libosmesa6 libyaml-cpp libc6; do
  [[ $depends == *"$library"* ]] || { echo "expected $library in what the package depends on, found $depends"; exit 1; }
done
[ ! -e "$work/root/usr/include" ] || { echo "headers belong to developers"; exit 1; }

# What it names is what it brings: a scenario that only the package has.
cd "$work/elsewhere"
share=$work/root/usr/share/swiftlet
printf 'base: field\nname: only_here\nduration_s: 0.1\n' >"$share/scenarios/only_here.yaml"
"$work/root/usr/bin/swiftlet" run only_here -q --out run
grep -q '"only_here"' run/summary.json
zcat "$work/root/usr/share/man/man1/swiftlet.1.gz" | grep -q '^.TH SWIFTLET'
bash -n "$work/root/usr/share/bash-completion/completions/swiftlet"
