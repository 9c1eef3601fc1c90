#!/usr/bin/env bash
# The Debian package of the program holds all that it needs, and every statement of the version agrees. Usage: package_test.sh BUILD_DIR
set -euo pipefail
build=$(cd "$1" && pwd)
source=$(cd "$(dirname "$0")/../.." && pwd)
umask 022  # as tools/package
command -v dpkg-shlibdeps >/dev/null || { echo "skipped: dpkg-dev is not installed"; exit 77; }
work=$build/package_test
rm -rf "$work"
mkdir -p "$work/elsewhere"
cpack -G DEB --config "$build/CPackConfig.cmake" -B "$work" -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip >"$work/log" 2>&1 ||
  { cat "$work/log"; exit 1; }
package=$(echo "$work"/swiftlet_*.deb)
dpkg-deb -x "$package" "$work/root"
depends=$(dpkg-deb -f "$package" Depends)
case $("$build/swiftlet" --version) in
  *OSMesa) pictures=libosmesa6 ;;
  *EGL) pictures=libgl1-mesa-dri ;;
  *) pictures= ;;
esac
for library in libembree libbullet $pictures libyaml-cpp libc6; do
  [[ $depends == *"$library"* ]] || { echo "expected $library in what the package depends on, found $depends"; exit 1; }
done
[ ! -e "$work/root/usr/include" ] || { echo "headers belong to developers"; exit 1; }
[ -f "$work/root/usr/share/doc/swiftlet/docs/tutorial.md" ] || { echo "expected docs/tutorial.md in the package"; exit 1; }
private=$(dpkg-deb -c "$package" | grep -vE '^(drwxr-xr-x|-rwxr-xr-x|-rw-r--r--) ' || true)
[ -z "$private" ] || { echo "expected what every account can read, found"; echo "$private"; exit 1; }

# The program finds the package's own assets: a scenario that only the package has.
cd "$work/elsewhere"
share=$work/root/usr/share/swiftlet
printf 'base: field\nname: only_here\nduration_s: 0.1\n' >"$share/scenarios/only_here.yaml"
"$work/root/usr/bin/swiftlet" run only_here -q --out run
grep -q '"only_here"' run/summary.json
zcat "$work/root/usr/share/man/man1/swiftlet.1.gz" | grep -q '^.TH SWIFTLET'
bash -n "$work/root/usr/share/bash-completion/completions/swiftlet"

# All files state one version and one date of release.
expect() { [ "$2" = "$3" ] || { echo "$1: expected $2, found $3"; exit 1; }; }
version=$("$work/root/usr/bin/swiftlet" --version | cut -d ' ' -f 1)
released=$(sed -n 's/^## \([0-9].*\)/\1/p' "$source/CHANGELOG.md" | head -n 1)
expect CHANGELOG.md "$version ($(sed -n 's/^date-released: //p' "$source/CITATION.cff"))" "$released"
expect CITATION.cff "$version" "$(sed -n 's/^version: //p' "$source/CITATION.cff")"
expect CMakeLists.txt "$version" "$(sed -n 's/^project(swiftlet VERSION \([^ ]*\) .*/\1/p' "$source/CMakeLists.txt")"
expect docs/site.yml "Swiftlet $version" "$(sed -n 's/^site_name: //p' "$source/docs/site.yml")"
expect README.md "$version" "$(sed -n 's/.*\[version \([^]]*\)\].*/\1/p' "$source/README.md")"
expect "the package" "$version-1~$(. /etc/os-release && echo "$ID${VERSION_ID:-}")" "$(dpkg-deb -f "$package" Version)"
