# A port of gmis for vcpkg. In an overlay: vcpkg install gmis
# --overlay-ports=examples/packaging/vcpkg Without an address it builds the sources that it lies in.
# To build a release, put vcpkg_from_github(OUT_SOURCE_PATH SOURCE_PATH REPO … REF v${VERSION}
# SHA512 …) in place of the first line.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../../.." ABSOLUTE)

set(VCPKG_BUILD_TYPE release) # headers alone
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS -DGMIS_BUILD_TESTS=OFF -DGMIS_BUILD_EXAMPLES=OFF -DGMIS_BUILD_BENCH=OFF -DGMIS_INSTALL=ON
          -DGMIS_FETCH_DEPENDENCIES=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH share/cmake/gmis)
vcpkg_fixup_pkgconfig()

file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/lib" "${CURRENT_PACKAGES_DIR}/share/doc")
file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
