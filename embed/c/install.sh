#!/usr/bin/env bash
# Installs the C library below a folder: `embed/c/install.sh /usr/local`. With it pkg-config finds `halfdome`, and CMake's
# find_package(halfdome) makes the targets halfdome::shared and halfdome::static.
set -euo pipefail
[ $# -eq 1 ] || { echo "usage: $0 FOLDER" >&2; exit 1; }
mkdir -p "$1"
prefix=$(cd "$1" && pwd)
cd "$(dirname "$0")"

cargo build --release -p halfdome-c
target=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"target_directory":"\([^"]*\)".*/\1/')/release
version=$(cargo metadata --format-version 1 --no-deps | sed 's/.*"name":"halfdome-c","version":"\([^"]*\)".*/\1/')
if [ "$(uname)" = Darwin ]; then shared=libhalfdome_c.dylib libraries="-lm"; else shared=libhalfdome_c.so libraries="-lpthread -ldl -lm"; fi

install -d "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/halfdome"
install -m 644 include/halfdome.h "$prefix/include/"
install -m 644 "$target/libhalfdome_c.a" "$prefix/lib/"
install -m 755 "$target/$shared" "$prefix/lib/"

cat > "$prefix/lib/pkgconfig/halfdome.pc" <<END
prefix=\${pcfiledir}/../..

Name: halfdome
Description: Ray tracing on the processor: trees of triangles, scenes of instances
Version: $version
Cflags: -I\${prefix}/include
Libs: -L\${prefix}/lib -lhalfdome_c
Libs.private: $libraries
END

cat > "$prefix/lib/cmake/halfdome/halfdomeConfig.cmake" <<END
get_filename_component(_halfdome "\${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
foreach(_kind SHARED STATIC)
  string(TOLOWER \${_kind} _name)
  if(NOT TARGET halfdome::\${_name})
    add_library(halfdome::\${_name} \${_kind} IMPORTED)
    set_target_properties(halfdome::\${_name} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "\${_halfdome}/include")
  endif()
endforeach()
set_target_properties(halfdome::shared PROPERTIES IMPORTED_LOCATION "\${_halfdome}/lib/$shared" IMPORTED_NO_SONAME TRUE)
set_target_properties(halfdome::static PROPERTIES IMPORTED_LOCATION "\${_halfdome}/lib/libhalfdome_c.a"
  INTERFACE_LINK_LIBRARIES "$libraries")
END

cat > "$prefix/lib/cmake/halfdome/halfdomeConfigVersion.cmake" <<END
set(PACKAGE_VERSION "$version")
string(REGEX MATCH "^[0-9]+[.][0-9]+" _halfdome_series "$version")
if(PACKAGE_FIND_VERSION VERSION_LESS_EQUAL PACKAGE_VERSION AND "\${PACKAGE_FIND_VERSION}." MATCHES "^\${_halfdome_series}[.]")
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
endif()
if("\${PACKAGE_FIND_VERSION}" VERSION_EQUAL "$version")
  set(PACKAGE_VERSION_EXACT TRUE)
endif()
END
echo "Installed below $prefix."
